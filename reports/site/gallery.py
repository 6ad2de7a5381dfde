"""Pages of the site: the gallery of scenes, the capabilities of engines, and the truths."""

from collections.abc import Callable, Collection, Iterable
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from cross_checks import engines
from cross_checks.judge.capabilities import Capability
from cross_checks.judge.cell import refusal_of, truth_of
from cross_checks.judge.consensus import LEVELS
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.records.figures import work_precision
from cross_checks.records.record import Record, usable
from cross_checks.truths.certificate import stored
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, scenes
from mbs_ref.scene.traits import traits
from reports.facts.scene_facts import filmed
from reports.film.files import as_gif, as_page, beside
from reports.scene_summary import summary

TARGETS = (1e-3, 1e-6)  # over the scene's scales
WORK = 50_000  # steps times bodies that a run of a plot may take
TRUTH_WORK = 300_000  # the same of a run that stands for a truth where none is certified
SCRIPT = "directory"  # plotly's script stands once beside the plots
SECONDS = 4.0  # that a film plays for


def rendered(name: str, **context: Any) -> str:
    """Return a page of the site in Markdown: a template of this package, filled in."""
    templates = Environment(loader=PackageLoader("reports.site"), undefined=StrictUndefined, trim_blocks=True)
    return templates.get_template(f"{name}.md.j2").render(context)


def who_can(scene: str, result: Iterable[Capability]) -> str:
    """Return the engines that run a scene."""
    return ", ".join(one.engine for one in result if one.installed and not one.scenes.get(scene, ("unknown",)))


def gallery(
    runs: Runs, names: Collection[str], able: Collection[Capability], pictures: Path, say: Callable[[str], None]
) -> str:
    """Return the page; films and plots go to `pictures`. What cannot be shown gives way to the reason."""
    entries = []
    for name in sorted(names):
        say(f"filming and timing {name}")
        scene = scenes.make(name)
        entries.append((scene, _facts(runs, scene, able, pictures), _film(scene, pictures)))
    return rendered("gallery", targets=[f"{target:g}" for target in TARGETS], work=WORK, entries=entries)


def _facts(runs: Runs, scene: Scene, able: Collection[Capability], pictures: Path) -> dict[str, str]:
    known = stored(scene)
    return {
        "made of": summary(scene).sentence(), "traits": ", ".join(sorted(traits(scene))) or "none",
        "who can": who_can(scene.name, able) or "nobody that is installed",
        "truth": "computed at its first use" if known is None else f"{known.kind}, known to {known.uncertainty:.1e} m",
        "what accuracy costs": _trade(runs, scene, pictures), "source": scene.source or "this project",
        "again": f"`mbs-ref simulate {scene.name}`",
    }  # fmt: skip


def _trade(runs: Runs, scene: Scene, pictures: Path) -> str:
    """Write the work-precision plot; return what leads to it, or the sentence why there is none."""
    target = pictures / f"{scene.name}-work-precision.html"
    missing = write_trade(runs, scene, target)
    again = f"`mbs-ref sweep {scene.name} --plot {scene.name}.html` searches without a bound"
    return f"not shown: {missing}; {again}" if missing else f"[work-precision plot](gallery/{target.name})"


def _film(scene: Scene, pictures: Path) -> str:
    """Write a film; return what shows it, or the sentence why there is none."""
    path, why = filmed(scene)
    if path is None:
        return f"{why}."
    target, film = pictures / f"{scene.name}.gif", beside(scene, {"": path})
    target.write_bytes(as_gif(film, SECONDS))
    target.with_suffix(".html").write_bytes(as_page(scene.name, film, path.times, SECONDS))
    return f"![{scene.name} in motion](gallery/{target.name})\n\n[Go through it](gallery/{scene.name}.html)"


def write_trade(runs: Runs, scene: Scene, target: Path) -> str:
    """Write the plot of every installed engine's own choice of method; return an empty text, or why there is none."""
    truth = _plot_truth(runs, scene)
    if isinstance(truth, NoTruth):
        return truth.reason
    records = [record for name in entrants() for record in _searched(runs, scene, name, truth)]
    if not any(usable(record) for record in records):
        return "no engine's own choice of method reaches the end"
    work_precision(records).write_html(target, include_plotlyjs=SCRIPT)
    return ""


def entrants() -> list[str]:
    """Return the engines whose runs are plotted."""
    return engines.names()


def _plot_truth(runs: Runs, scene: Scene) -> Truth | NoTruth:
    """Return the certified truth, or what engines agree on where their finest runs are within the bound on work."""
    truth, steps, bodies = runs.truth(scene), round(1.0 / min(LEVELS[1]["fixed"])), len(scene.bodies)
    if not isinstance(truth, NoTruth) or steps * bodies <= TRUTH_WORK:
        return truth_of(runs, scene)
    price = f"{steps:,} steps of {bodies} bodies a run, more than {TRUTH_WORK:,} of both"
    return NoTruth(f"{truth.reason}, and what engines agree on would take {price}")


def _searched(runs: Runs, scene: Scene, name: str, truth: Truth) -> list[Record]:
    """Return the runs that the search makes with an engine's default method; none where it is missing or refuses."""
    try:
        method = engines.get(name).method(None)
    except engines.EngineMissing:
        return []
    if refusal_of(scene, name, method):
        return []
    most = max(1, WORK // len(scene.bodies))
    return list(search(runs, scene, name, method, truth, TARGETS, most)[0].records.values())
