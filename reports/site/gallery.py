"""The gallery: each scene's film, what it is made of, who can run it at what cost, how well its truth is known."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

from cross_checks.judge.capabilities import Capability, capabilities
from cross_checks.judge.runs import Runs
from cross_checks.truths.certificate import stored
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import traits
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.film.files import as_gif, as_page, beside
from reports.scene_summary import summary
from reports.site.tables import table, who_can
from reports.site.trade import BOUNDS, write_trade

PICTURES = 40  # of a film
SECONDS = 4.0  # that it plays for
MOST_BODIES = 120  # of a scene that is filmed: others take minutes
LEAD = (
    "# Gallery\n\nEvery scene as it comes. `mbs-ref scenes NAME` prints its parameters with their ranges, "
    "`mbs-ref scenes NAME --files .` writes it as TOML, `mbs-ref check NAME` holds every engine against its truth. "
    f"{BOUNDS}\n"
)


def gallery(runs: Runs, names: Collection[str], pictures: Path, say: Callable[[str], None]) -> str:
    """Return the page; films and plots go to `pictures`. What cannot be shown gives way to the reason."""
    able, parts = capabilities(), [LEAD]
    for name in sorted(names):
        say(f"filming and timing {name}")
        parts.append(_entry(runs, scenes.make(name), able, pictures))
    return "\n".join(parts)


def _entry(runs: Runs, scene: Scene, able: Collection[Capability], pictures: Path) -> str:
    known = stored(scene)
    truth = "made when it is first asked for" if known is None else f"{known.kind}, known to {known.uncertainty:.1e} m"
    rows = [
        ["made of", summary(scene).sentence()],
        ["traits", ", ".join(sorted(traits(scene))) or "none"],
        ["who can", who_can(scene.name, able) or "nobody that is installed"],
        ["truth", truth],
        ["what accuracy costs", _trade(runs, scene, pictures)],
        ["source", scene.source or "this project"],
        ["again", f"`mbs-ref simulate {scene.name}`"],
    ]
    return f"## {scene.name}\n\n{scene.description}\n\n{_film(scene, pictures)}\n\n{table(['', ''], rows)}"


def _trade(runs: Runs, scene: Scene, pictures: Path) -> str:
    """Write the work-precision plot; return what leads to it, or the sentence why there is none."""
    target = pictures / f"{scene.name}-work-precision.html"
    missing = write_trade(runs, scene, target)
    again = f"`mbs-ref sweep {scene.name} --plot {scene.name}.html` asks without a bound"
    return f"not shown: {missing}; {again}" if missing else f"[work-precision plot](gallery/{target.name})"


def _film(scene: Scene, pictures: Path) -> str:
    """Write a film; return what shows it, or the sentence why there is none."""
    if len(scene.bodies) > MOST_BODIES:
        return f"Not filmed here: {len(scene.bodies)} bodies. `mbs-ref animate {scene.name} -o film.gif` does."
    path = simulate(scene, Settings(samples=PICTURES, estimate="off", reactions=False))
    if not path.ok:
        return f"Not filmed: {path.message}."
    target, film = pictures / f"{scene.name}.gif", beside(scene, {"": path})
    target.write_bytes(as_gif(film, SECONDS))
    target.with_suffix(".html").write_bytes(as_page(scene.name, film, path.times, SECONDS))
    return f"![{scene.name} in motion](gallery/{target.name})\n\n[Go through it](gallery/{scene.name}.html)"
