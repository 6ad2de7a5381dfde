"""The papers' claims, measured: the crash, the track, the planets, and two forms of the equations."""

from __future__ import annotations

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured, Value
from reports.studies.papers.coordinates import coordinates
from reports.studies.papers.crash_figures import measure_crash
from reports.studies.papers.formulations import euler_angles, multipliers
from reports.studies.papers.outline_pictures import outline_pictures
from reports.studies.papers.satellite_figures import satellites
from reports.studies.papers.sky_figures import measure_sky
from reports.studies.papers.track_figures import measure_track

TILTS = (0.1, 1e-3, 1e-8)  # rad, by which an axis misses the pole
INDICES = ("dassl_index1", "dassl_index2", "dassl", "dassl_index3")


def measure() -> Measured:
    """Run everything; two minutes with compiled code at hand."""
    crash, track = measure_crash(), measure_track()
    figures = crash.figures | track.figures | measure_sky() | multipliers() | coordinates() | satellites() | _indices()
    for tilt in TILTS:
        figures |= {f"angles.{tilt:g}.{name}": value for name, value in euler_angles(tilt).items()}
    return Measured(figures, outline_pictures(), crash.curves | track.curves, crash.films | track.films)


def _indices() -> dict[str, Value]:
    """Return |C| of a slider-crank by DASSL at index 1, 2, stabilised 2 and 3, without help."""
    figures: dict[str, Value] = {}
    for method in INDICES:
        path = simulate(scenes.make("slider_crank"), Settings(method=method, rtol=1e-4, stabilization="none"))
        kept = path.step_compliance
        figures[f"{method}.compliance"] = float(kept[:, 1].max()) if path.ok and kept is not None else path.message
    return figures
