"""The figures of the tracked vehicle, from runs of no law that stand in for its own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mbs_ref import Settings
from mbs_ref.trajectory import Status, Timing, Trajectory
from reports.studies.crash import RAN
from reports.studies.papers import track_figures

NAMES = ("chassis", "idler", "roller1", "roller2", "roller3")
RADII = {"idler": 0.3, "roller2": 0.2}  # m, of the circles that touch lines


def scene_of(name: str, **parameters: Any) -> Any:
    """Return a scene that holds what it was made of, and wheels whose circles touch circles, too."""
    contacts = [SimpleNamespace(body_a=wheel, type=kind, radius=radius) for wheel, kind, radius in (
        ("idler", "circle_on_circle", 9.0), ("roller1", "circle_on_line", 8.0),
        *((wheel, "circle_on_line", radius) for wheel, radius in RADII.items()))]  # fmt: skip
    return SimpleNamespace(name=name, parameters=parameters, body_index=NAMES.index, contacts=contacts)


class Drives:
    """Runs by scene and settings, each of random numbers."""

    def __init__(self, statuses: dict[str, Status] | None = None) -> None:
        self.rng, self.statuses = np.random.default_rng(3), statuses or {}
        self.asked: list[tuple[Any, Settings, Any]] = []
        self.made: list[Trajectory] = []

    def simulate(self, scene: Any, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        self.asked.append((scene, settings, times))
        n = 6 if times is None else len(times)
        shapes, status = ((5, 2), (5,), (5, 2), (5,)), self.statuses.get(settings.method or "auto", Status.SUCCESS)
        gaps = 1e-9 * self.rng.uniform(1.0, 9.0, (n, 2))
        self.made.append(Trajectory(
            np.arange(float(n)), *(self.rng.normal(size=(n, *one)) for one in shapes), status=status, message="why",
            step_compliance=gaps, timing=Timing(loop_s=float(self.rng.uniform(1.0, 2.0))),
        ))  # fmt: skip
        return self.made[-1]


@pytest.mark.parametrize("rests", [True, False])
def test_wheels_that_roll_and_wheels_that_slide(monkeypatch, rests):
    drives = Drives({} if rests else {"auto": Status.SINGULAR})
    slips = {wheel: np.array([np.nan, 0.01 * k, -0.5 + 0.1 * k]) for k, wheel in enumerate(track_figures.WHEELS)}
    monkeypatch.setattr(track_figures, "simulate", drives.simulate)
    monkeypatch.setattr(track_figures.scenes, "make", scene_of)
    monkeypatch.setattr(track_figures, "Motion", lambda scene, path: (scene, path))
    monkeypatch.setattr(
        track_figures, "rolling_slip", lambda motion, wheel: motion[1] is drives.made[0] and slips[wheel]
    )
    monkeypatch.setattr(track_figures, "_own_contacts", lambda scene, path: {"own": path is drives.made[0]})
    figures, drawn = track_figures._rolling()
    path, sliding, still = drives.made
    every = sorted(abs(x) for own in slips.values() for x in own[1:])
    turns = max(abs(rate) for row in sliding.angular_velocity for rate in row[1:])
    far = max(abs(x - y) for row in still.position for a, b in zip(row, still.position[0], strict=True)
              for x, y in zip(a, b, strict=True))  # fmt: skip
    assert figures == {
        "track.rest": pytest.approx(far) if rests else "why", "track.slip_median": pytest.approx(np.mean(every[3:5])),
        "track.slip_95": pytest.approx(np.percentile(every, 95)), "track.slip_most": pytest.approx(0.5),
        "track.sliding_turns": pytest.approx(turns),
        "track.travel": pytest.approx(path.position[5, 0, 0] - path.position[0, 0, 0]),
        "track.sliding_travel": pytest.approx(sliding.position[5, 0, 0] - sliding.position[0, 0, 0]), "own": True,
    }  # fmt: skip
    lines = drawn["Track: wheels roll"].lines
    assert lines["chassis"] == pytest.approx(path.velocity[:, 0, 0], rel=1e-5)
    assert lines["idler's rim"] == pytest.approx(-0.3 * path.angular_velocity[:, 1], rel=1e-5)
    assert lines["roller2's rim"] == pytest.approx(-0.2 * path.angular_velocity[:, 3], rel=1e-5)
    long = Settings(method="rk4", step=1e-4, t_end=2.0, samples=401, estimate="off")
    resting = Settings(t_end=10.0, estimate="off", reactions=False)
    chosen = [({}, long), ({"model": "paper"}, long), ({"torque": 0.0}, resting)]
    assert [(scene.parameters, settings) for scene, settings, _ in drives.asked] == chosen


def test_methods_and_engines_drive_the_track_at_the_times_of_the_finest_run(monkeypatch):
    """The papers' own methods without stabilization, and stopped by their test of the compliance."""
    drives, engines = Drives({"euler": Status.COMPLIANCE, "radau": Status.SINGULAR}), []
    methods = ("rk4", "euler", "radau")
    monkeypatch.setitem(RAN["methods"], "track", {name: {"step": 1e-3} for name in methods})
    monkeypatch.setattr(track_figures, "simulate", drives.simulate)
    monkeypatch.setattr(track_figures.scenes, "make", scene_of)
    monkeypatch.setattr(
        track_figures, "farthest", lambda scene, one, other: [len(drives.made), other is drives.made[0]]
    )
    monkeypatch.setattr(track_figures, "_engine", lambda scene, name, settings, fine: engines.append(
        (name, settings, fine is drives.made[0])) or f"{name} {settings.method}")  # fmt: skip
    monkeypatch.setattr(track_figures, "_held", lambda times: {"held": times[-1]})
    monkeypatch.setattr(track_figures, "_rolling", lambda: ({"rolled": 1.0}, {}))
    monkeypatch.setattr(track_figures, "film", lambda scene, path, each: (scene.parameters, path, each))
    found = track_figures.measure_track()
    fine, *tried, dassl, rough = drives.made
    assert all(times is not None and np.array_equal(times, np.linspace(0.0, 0.5, 26)) for *_, times in drives.asked[:4])
    expected: dict[str, Any] = {"held": 0.5, "rolled": 1.0}
    words = {"rk4": "keeps", "euler": "fails", "radau": "why"}
    for k, (name, path) in enumerate(zip(methods, tried, strict=True)):
        assert path.step_compliance is not None
        expected |= {f"track.{name}.test": words[name], f"track.{name}.until": 25.0,
                     f"track.{name}.compliance": path.step_compliance[:, 1].max(),
                     f"track.{name}.apart": k + 2 if name == "rk4" else "stopped",
                     f"track.{name}.loop_s": path.timing.loop_s}  # fmt: skip
    assert dassl.step_compliance is not None
    expected |= {"track.dassl.compliance": dassl.step_compliance[:, 1].max(), "track.dassl.loop_s": dassl.timing.loop_s,
                 "track.pinocchio.finest_apart": "pinocchio dop853", "track.pinocchio.apart": "pinocchio rk4",
                 "track.exudyn.apart": "exudyn generalized_alpha"}  # fmt: skip
    assert found.figures == expected
    lean: dict[str, Any] = {"reactions": False, "estimate": "off"}
    plain: dict[str, Any] = {"step": 1e-3, "max_steps": 10**6, **lean}
    papers: dict[str, Any] = plain | {"stabilization": "none", "stop_on_compliance": True}
    reference = Settings(method="rk4", step=5e-5, **lean)
    assert [settings for _, settings, _ in drives.asked] == [
        reference, *(Settings(method=name, **papers) for name in methods[:2]), Settings(method="radau", **plain),
        Settings(method="dassl", rtol=1e-4, t_end=0.05, **lean),
        Settings(method="rk4", step=1e-4, t_end=2.0, samples=81, **lean),
    ]  # fmt: skip
    assert engines == [("pinocchio", Settings(method="dop853", rtol=1e-9, reactions=False), True),
                       ("pinocchio", Settings(method="rk4", step=1e-4, reactions=False), True),
                       ("exudyn", Settings(method="generalized_alpha", step=1e-4, reactions=False), True)]  # fmt: skip
    bump = {"suspension": True, "ground": "bump", "height": 0.05}
    assert found.films == {"Track over a bump": (bump, rough, 10)}
    pitch = found.curves["Hull's pitch over a bump of 5 cm, rollers sprung"].lines["pitch"]
    assert pitch == pytest.approx(rough.orientation[:, 0] * 180.0 / np.pi, rel=1e-5)
    assert fine is drives.made[0]
