"""Pages of the site: the gallery of scenes, the capabilities of engines, and the truths."""

from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path

from cross_checks import engines
from cross_checks.judge.capabilities import Capability, capabilities
from cross_checks.judge.cell import refusal_of, truth_of
from cross_checks.judge.consensus import LEVELS
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.records.figures import work_precision
from cross_checks.records.record import Record, usable
from cross_checks.truths.certificate import every, stored
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, scenes
from mbs_ref.scene.traits import traits
from reports.facts.capability_tables import tables
from reports.facts.scene_facts import filmed
from reports.film.files import as_gif, as_page, beside
from reports.scene_summary import summary

ABSENT = "-"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown; a bar in a cell does not end it."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def capability_page() -> str:
    """Return which parts and scenes every installed engine takes, and why not where it refuses."""
    shown = (f"## {title}\n\n{table(head, rows)}" for title, head, rows in tables(capabilities()))
    lead = "Derived from the adapters when these pages were built; `mbs-ref engines --json` has every reason in full.\n"
    return "\n".join(["# What each engine can\n", lead, *shown])


def who_can(scene: str, result: Iterable[Capability]) -> str:
    """Return the engines that run a scene."""
    return ", ".join(one.engine for one in result if one.installed and not one.scenes.get(scene, ("unknown",)))


def truth_page() -> str:
    """Return every stored certificate: how well a truth is known, and how that is known."""
    rows = []
    for one in every():
        name = " ".join([f"`{one.scene}`", *(f"{key}={value}" for key, value in one.parameters.items())])
        within = ABSENT if one.confirmed_to is None else f"{one.confirmed_to:.1e}"
        rows.append([name, one.kind, f"{one.uncertainty:.1e}", within, one.how])
    head = ["scene", "kind", "known to, m", "our solver within, m", "how"]
    return (
        "# Truths and how well they are known\n\nCertificates of the tree; `mbs-ref certify SCENE` computes one "
        "again and exits with 1 where it differs. Scenes without one get their truth at its first use.\n\n"
        + table(head, rows)
    )


TARGETS = (1e-3, 1e-6)  # over the scene's scales
WORK = 50_000  # steps times bodies that a run of a plot may take
TRUTH_WORK = 300_000  # the same of a run that stands for a truth where none is certified
SCRIPT = "directory"  # plotly's script stands once beside the plots
BOUNDS = (
    f"A plot tries for errors of {TARGETS[0]:g} and {TARGETS[1]:g} with each engine's own choice of method, in runs of "
    f"at most {WORK:,} steps times bodies; `mbs-ref sweep NAME --plot NAME.html` draws every method without that bound."
)
SECONDS = 4.0  # that it plays for
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
    truth = "computed at its first use" if known is None else f"{known.kind}, known to {known.uncertainty:.1e} m"
    rows = [
        ["made of", summary(scene).sentence()], ["traits", ", ".join(sorted(traits(scene))) or "none"],
        ["who can", who_can(scene.name, able) or "nobody that is installed"], ["truth", truth],
        ["what accuracy costs", _trade(runs, scene, pictures)], ["source", scene.source or "this project"],
        ["again", f"`mbs-ref simulate {scene.name}`"],
    ]  # fmt: skip
    return f"## {scene.name}\n\n{scene.description}\n\n{_film(scene, pictures)}\n\n{table(['', ''], rows)}"


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
