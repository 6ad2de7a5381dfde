"""mbs-ref pick: the cheapest setting that reaches an accuracy."""

from collections.abc import Sequence
from dataclasses import asdict, astuple, replace
from pathlib import Path
from typing import Any

import click

from benchmarks.record_changes import BY_MACHINE
from cross_checks.conformance.loading import name_of
from cross_checks.isolation.parent import Lost
from cross_checks.judge.cell import truth_of
from cross_checks.prices import pick
from cross_checks.prices.pick import Bounds, Choice
from cross_checks.prices.timing import Comparison
from cross_checks.records import lines as record_file
from cross_checks.records.record import BUSY_NOTE, Record
from mbs_ref import Scene
from reports import inputs
from reports.console import Failed, Incomplete, NothingSelected, complain, echo_json
from reports.page.slug import command as reproduce
from reports.query import STORE, Interrupted, isolated, open_runs, sweep_records

PATIENCE = 600.0  # s for a run that is known to finish: loading compiled code on a busy machine may take minutes


@click.command(name="pick", epilog="Example: mbs-ref pick slider_crank --error 1mm --engine exudyn --engine mujoco")
@inputs.scene_options
@inputs.ENGINES
@click.option("--error", metavar="E|1mm", required=True, help="Largest error, of the scene's scales or as 1mm.")
@click.option("--compliance", type=inputs.POSITIVE, help="Largest constraint violation, m or rad.")
@click.option("--budget", metavar="50ms", help="Longest loop time.")
@click.option("--real-time", is_flag=True, help="The loop must take no longer than the motion lasts.")
@click.option("--records", type=inputs.FILE, help="Choose among the records of a sweep's JSON lines: no sweep.")
@click.option(
    "--confirm/--no-confirm", "confirming", default=None,
    help=f"Time the winner against the runner-up in interleaved runs.  [default: where it leads by less than "
    f"{pick.CLOSE} times]",
)  # fmt: skip
@click.option(
    "--models", is_flag=True, help="Choose among the models of SCENE's family, from least to most, not among settings."
)
@click.option("--fresh", is_flag=True, help="Run the chosen setting afresh; exit code 1 where it misses.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@STORE
def command(
    scene: str, parameters: tuple[str, ...], keep_rates: tuple[str, ...], chosen: tuple[str, ...], error: str,
    compliance: float | None, budget: str | None, real_time: bool, records: Path | None, confirming: bool | None,
    models: bool, fresh: bool, as_json: bool, store: str | None,
) -> None:  # fmt: skip
    """Name the cheapest setting that reaches --error on SCENE.

    A line for each installed engine states its best setting, or why it does not run the scene. For each engine that
    --engine names, the error of its default settings is printed, too.
    """
    if models:
        _pick_model(scene, parameters, error, as_json)
        return
    limit = None if budget is None else inputs.seconds(budget)
    built = inputs.comparable(scene, parameters, keep_rates)
    if real_time:
        limit = min(built.duration, limit or built.duration)
    wanted = inputs.relative_error(error, built)
    bounds = Bounds(wanted, compliance, limit)
    result = _swept(built, chosen, store, bounds, as_json) if records is None else _of_scene(records, built, chosen)
    _warn(result)
    choice, duel = _confirmed(built, pick.pick(result, *astuple(bounds)), confirming)
    again = _afresh(built, choice, store) if fresh else None
    shipped = _as_shipped(built, chosen, store)
    again_by = None if choice.best is None else reproduce(choice.best, scene, keep_rates)
    engines = pick.of_engines(result, bounds)
    if as_json:
        facts = _facts(choice, duel, again, again_by)
        echo_json(facts | {"engines": engines, "as_shipped": [asdict(one) for one in shipped]})
    elif any(record.error for record in result):
        click.echo(pick.basis(result), err=True)
        lines = [] if again_by is None else [choice.sentence, again_by]
        click.echo("\n".join([*lines, "", "Each engine", *engines, *map(pick.shipped, shipped)]).strip())
    if choice.best is None:
        raise NothingSelected(choice.sentence)
    if again is not None:
        _check(again, bounds)


def _swept(scene: Scene, chosen: tuple[str, ...], store: str | None, bounds: Bounds, as_json: bool) -> list[Record]:
    """Return the runs to choose among; where the sweep is interrupted, print the best of those so far."""

    def best(records: Sequence[Record]) -> str:
        known = any(record.error for record in records)
        return f"{pick.pick(records, *astuple(bounds)).sentence.rstrip('.')}. {pick.basis(records)}" if known else ""

    try:
        return sweep_records(
            scene, chosen, (), None, store=store, errors=(bounds.error,), best=best,
            worth=lambda records: pick.contenders(records, bounds),
        )  # fmt: skip
    except Interrupted as interrupted:
        if as_json:
            echo_json(_facts(pick.pick(interrupted.records, *astuple(bounds)), None, None, None))
        else:
            click.echo(f"Provisional: {best(interrupted.records) or pick.basis(interrupted.records)}")
        raise


def _pick_model(scene: str, parameters: tuple[str, ...], error: str, as_json: bool) -> None:
    """Print the least model of the scene's family that reaches the error."""
    from reports.studies.models import choose, families, of_family

    ladder = None if parameters else of_family(scene)
    if ladder is None:
        raise click.UsageError(
            f"--models knows the families of {', '.join(families())}, without parameters of their own; got {scene!r}"
        )
    choice = choose(ladder, inputs.relative_error(error, inputs.scene(scene, ())))
    if as_json:
        echo_json(asdict(choice))
    if choice.best is None:
        raise NothingSelected(choice.sentence)
    if not as_json:
        click.echo(choice.sentence)


def _of_scene(file: Path, scene: Scene, chosen: tuple[str, ...]) -> list[Record]:
    """Return the file's records of this very scene, and of the engines chosen."""
    records, problems = record_file.read(file)
    complain(problems)
    own = [r for r in records if (r.scene, r.parameters) == (scene.name, scene.parameters)]
    if not own:
        raise NothingSelected(f"{file} holds no record of {scene.name} with these parameters")
    names = {name_of(one) for one in chosen}
    return [r for r in own if not names or r.engine in names]


def _warn(records: list[Record]) -> None:
    """Print on stderr how many of the records were timed while others used the processor."""
    busy = sum(any(note.startswith(BUSY_NOTE) for note in record.notes) for record in records)
    if busy:
        click.echo(f"{busy} of {len(records)} runs were timed on a busy machine: take care with the margin", err=True)


def _confirmed(scene: Scene, choice: Choice, wanted: bool | None) -> tuple[Choice, Comparison | None]:
    if choice.runner_up is None or choice.margin is None:
        return choice, None
    if wanted is False or (wanted is None and choice.margin >= pick.CLOSE):
        return choice, None
    try:
        with isolated([scene], PATIENCE) as call:
            duel = pick.duel(scene, choice, call)
    except Lost as lost:
        return replace(choice, sentence=f"{choice.sentence} Not confirmed: a timed run {lost}."), None
    return pick.settled(choice, duel), duel


def _as_shipped(scene: Scene, chosen: tuple[str, ...], store: str | None) -> list[Record]:
    """Return the runs of the engines named as they come, without their curves."""
    if not chosen:
        return []
    with open_runs([scene], store, PATIENCE) as runs:
        built = [pick.as_shipped(runs, scene, name_of(one)) for one in chosen]
    return [replace(record, history={}) for record in built if record is not None]


def _afresh(scene: Scene, choice: Choice, store: str | None) -> Record | None:
    if choice.best is None:
        return None
    with open_runs([scene], store, PATIENCE) as runs:
        return pick.afresh(scene, choice.best, truth_of(runs, scene), runs.call)


def _check(again: Record, bounds: Bounds) -> None:
    """Print what the setting reaches when it is run afresh."""
    reached = "no error" if again.error is None else f"{again.error.bound:.2e}"
    gap = again.measure("compliance_position")
    text = f"run afresh: {again.status}, {reached}, joints open by {'nothing known' if gap is None else f'{gap:.2e}'}"
    if again.status in BY_MACHINE:
        raise Incomplete(f"{text}: {again.message}")
    if not bounds.met_by(again):
        raise Failed(f"{text}: the bounds are not met {again.message}".rstrip())
    click.echo(f"{text}: the bounds are met", err=True)


def _facts(choice: Choice, duel: Comparison | None, again: Record | None, command: str | None) -> dict[str, Any]:
    """Return the choice as plain data, with the command that runs it, and without the curves of its records."""
    facts = asdict(choice) | {"duel": None if duel is None else asdict(duel), "fresh": again and asdict(again)}
    limit = facts["limit"]
    for record in (facts["best"], facts["runner_up"], facts["fresh"], limit and limit["cheaper"]):
        if record is not None:
            del record["history"]
    return facts | {"command": command}
