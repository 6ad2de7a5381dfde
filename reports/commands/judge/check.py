"""mbs-ref check: the cross-validation table, and an exit code that stands for it."""

from collections.abc import Iterable
from dataclasses import replace

import click

from cross_checks.judge.answers import Answer, Question, answers, questions
from cross_checks.judge.bounds import CHECK, CHECKED
from cross_checks.judge.cell import tasks
from cross_checks.judge.vocabulary import Cell, Refused, refusals
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from reports import console, inputs
from reports.console import Failed, Incomplete, NothingSelected, number, progress, show_table
from reports.query import SCHEDULER, STORE, open_runs, reporting

MOST_REASONS = 5  # printed where nothing runs


@click.command(name="check", epilog="Example: mbs-ref check slider_crank --engine mbs_ref --engine exudyn")
@click.argument("scene", nargs=-1, metavar="[SCENE|FILE.toml]...")
@inputs.PARAMETERS
@inputs.KEEP
@inputs.ENGINES
@SCHEDULER
@inputs.SHARD
@click.option("--json", "as_json", is_flag=True, help="Print JSON: a list of cells.")
@STORE
def command(
    scene: tuple[str, ...], parameters: tuple[str, ...], keep_rates: tuple[str, ...], chosen: tuple[str, ...],
    scheduler: str | None, shard: str, as_json: bool, store: str | None,
) -> None:  # fmt: skip
    """Compare engines with each other and with the truth. Without SCENE, on every scene.

    Where no truth is certified, unlike engines compute a consensus truth; answers are provisional until that is
    accurate enough. Runs are stored and never repeated; they use all processors, each in a process of its own: one
    that hangs, crashes or eats memory costs its own cell. A target alone is worth no run of more than 15 s, unless the
    verdict is open or wrong; the cell states the time. After 9 min a scene no further run begins: cells state what is
    missing, and the command, repeated, continues. Any signal ends the command with what is known so far.
    Exit code 1 where a method is wrong where it does not declare that it is known to be.
    """
    for option, given in (("-p", parameters), ("--keep", keep_rates)):
        if given and len(scene) != 1:
            raise click.UsageError(f"{option} {given[0]} needs exactly one SCENE; {len(scene)} are named")
    selected = [inputs.comparable(name, parameters, keep_rates) for name in scene or scenes.names()]
    wanted = inputs.shard(questions(selected, tasks(inputs.engine_names(chosen))), shard)
    known: dict[Question, Answer] = {}
    interrupted = False
    try:
        with progress("check") as report, open_runs(selected, store, scheduler=scheduler) as runs:
            limited = replace(runs, longest=CHECKED, time_left=CHECK * len(selected))
            shown = reporting(report, lambda: _best(known.values()))
            for answer in answers(limited, wanted, progress=shown):
                known[answer.question] = answer
    except KeyboardInterrupt:
        interrupted = True
    best = [known[question] for question in wanted if question in known]
    cells = [answer.cell for answer in best]
    facts = [answer.cell.to_dict() | {"settled": answer.is_settled} for answer in best]
    console.answer(facts, None, as_json, lambda _: _show(cells))
    if interrupted:
        settled = sum(answer.is_settled for answer in best)
        raise Incomplete(f"interrupted after {settled} of {len(wanted)} cells. {_best(best)}")
    if not any(not cell.is_refused for cell in cells):
        why = {f"{cell.scene} by {cell.engine}": cell.reason for cell in reversed(cells)}  # an engine's first method
        sentence = [f"{where}: {reason}" for where, reason in reversed(why.items())]
        raise NothingSelected(f"no engine runs any of the scenes. {'. '.join(sentence[:MOST_REASONS])}")
    wrong = [cell for cell in cells if cell.is_wrong]
    if wrong:
        named = ", ".join(f"{cell.scene}/{cell.engine}/{cell.method}: {cell.verdict}" for cell in wrong)
        raise Failed(f"{len(wrong)} of {len(cells)} cells are wrong: {named}")


def _best(known: Iterable[Answer]) -> str:
    """Return the verdicts so far on the methods that run, and what the provisional ones are judged by."""
    verdicts: dict[str, list[str]] = {}
    truths: dict[str, str] = {}
    for answer in known:
        cell = answer.cell
        if answer.truth is not None:
            mark = "" if answer.is_settled else " (provisional)"
            verdicts.setdefault(f"{cell.scene}: {cell.verdict}{mark}", []).append(f"{cell.engine} {cell.method}")
        if isinstance(answer.truth, Truth) and not answer.is_settled:
            truths[cell.scene] = f"{cell.scene}: provisional while its truth is refined, {answer.truth.how}"
    return "\n  ".join([*(f"{verdict}: {', '.join(names)}" for verdict, names in verdicts.items()), *truths.values()])


def _show(cells: list[Cell]) -> None:
    rows = []
    for cell in [cell for cell in cells if not cell.is_refused]:
        figures = (number(value) for value in (cell.error, cell.compliance, cell.order))
        exemption = f" (documented: {cell.exemption})" if cell.exemption else ""
        verdict = f"{cell.verdict} {cell.code}"
        rows.append((cell.label, cell.engine, cell.method, verdict, *figures, f"{cell.reason}{exemption}"))
    show_table("", ("scene", "engine", "method", "verdict", "error", "compliance", "order", "reason"), rows)
    if refused := refusals(cells):
        show_table("\nRefused", Refused._fields, refused)
    if kinds := sorted({cell.truth for cell in cells if cell.truth}):
        click.echo(f"Errors are over each scene's own length and time; truths are {', '.join(kinds)}.", err=True)
    who = ("scene", "engine", "method")
    omitted, contact = [], []  # what runs that were left out would show, and figures of the run that speaks for a cell
    for cell in cells:
        name = (cell.label, cell.engine, cell.method)
        not_tried = [target for target in cell.targets if target.answer == "not-tried"]
        omitted += [(*name, number(target.target), str(target.omitted or target.reason)) for target in not_tried]
        figures = "; ".join(f"{figure} {number(value)}" for figure, value in cell.contact.items())
        contact += [(*name, figures)] if figures else []
    if omitted:
        show_table("\nNot tried", (*who, "target", "what a run would take and show"), omitted)
    if contact:
        show_table("\nContact", (*who, "figures"), contact)
