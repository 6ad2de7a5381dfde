"""mbs-ref contact: one contact in each engine's own parameters, and what each engine makes of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports import inputs
from reports.console import EngineAbsent, NothingSelected, complain, echo_json, progress, reported_as, show_table

if TYPE_CHECKING:
    from cross_checks.contact.request import ContactModel
    from mbs_ref import Scene


@click.command(name="contact", epilog="Example: mbs-ref contact --rebound 0.5 --friction 0.7 --stiffness 1e5 --mass 2")
@click.option("--rebound", type=float, help="Restitution of a free impact (-).")
@click.option("--friction", type=float, help="Coulomb's coefficient (-).")
@click.option("--stiffness", type=float, help="Of the contact (N/m).")
@click.option("--mass", type=float, help="Effective mass of the pair (kg): 1/(1/m_a + 1/m_b).")
@click.option("--speed", type=float, default=1.0, show_default=True, help="Of approach and of sliding (m/s).")
@click.option("--step", type=inputs.POSITIVE, default=1e-3, show_default=True, help="Of the engine (s).")
@click.option("--figures", is_flag=True, help="Compare scenes with contact by figures instead.")
@click.option("--scene", "only", metavar="SCENE", multiple=True, help="Only this scene; repeatable.")
@click.option("--holding", is_flag=True, help="Measure the creep of blocks that friction holds instead.")
@click.option(
    "--instant", type=inputs.NEW_FILE, metavar="FILE", help="Assess one step of --scene SCENE|FILE.toml instead."
)
@click.option("--at", type=float, default=0.0, metavar="T", help="Time of --instant (s); 0 unless given.")
@inputs.PARAMETERS
@click.option(
    "--tosses",
    type=click.IntRange(0),
    is_flag=False,
    flag_value=0,
    metavar="[N]",
    help="Compare predictions with measured tosses of a cube instead: all, or N drawn at random.",
)
@click.option(
    "--folder", type=inputs.FOLDER, help="Of other tosses than those of this package: ContactNets' .pt files."
)
@click.option("--engine", "chosen", multiple=True, metavar="E", help="Only this engine; repeatable.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines.")
def command(
    figures: bool, only: tuple[str, ...], holding: bool, instant: Path | None, at: float, parameters: tuple[str, ...],
    tosses: int | None, folder: Path | None, chosen: tuple[str, ...], as_json: bool, **request,
):  # fmt: skip
    """Translate a contact into the parameters of each engine.

    Small experiments measure what each engine makes of them. They hold for one pair of the given effective mass.
    --figures runs the library's scenes with contact by each engine's own contact model, --holding blocks that
    Coulomb's law holds. --instant writes the contact problem of a scene's state in FCLIB's layout
    (FILE.hdf5 needs h5py, else FILE.npz) and shows by how much each engine's step violates its conditions.
    --tosses predicts measured tosses of a cube by each law and engine, and shows the error of its corners.
    """
    from cross_checks import contact
    from cross_checks.contact import by_figure

    with reported_as(click.UsageError, ValueError):
        present, absent = contact.models(chosen or contact.ENGINES)
    if absent and (chosen or not present):
        raise EngineAbsent("; ".join(absent))
    if bool(figures) + bool(holding or instant) + bool(tosses is not None or folder) > 1:
        raise click.UsageError("--figures, --holding or --instant, and --tosses exclude each other")
    if (at or parameters) and (holding or not instant):
        raise click.UsageError("--at and -p go with --instant FILE --scene SCENE")
    if only and not (figures or holding or instant):
        raise click.UsageError("--scene goes with --figures, --holding or --instant")
    if instant and not holding:
        _print(_violations(present, [inputs.scene(name, parameters) for name in only], at, request["step"], instant),
               as_json)  # fmt: skip
    elif tosses is not None or folder:
        _print(_predictions(present, folder, request["step"], tosses or 0, each=as_json), as_json)
    elif figures or holding:
        cases = by_figure.holding() if holding else by_figure.with_contact()
        if unknown := [name for name in only if name not in cases]:
            raise NothingSelected(f"no scene here is named {unknown[0]!r}; allowed: {', '.join(cases)}")
        chosen_cases = {name: cases[name] for name in only or cases}
        if instant:
            _print(_violations(present, list(chosen_cases.values()), 0.0, request["step"], instant), as_json)
        else:
            _print(by_figure.compare(present, chosen_cases, request["step"], every=holding), as_json)
    else:
        _translate(present, request, as_json)
    complain(absent)


def _translate(models: dict[str, ContactModel], request: dict[str, float | None], as_json: bool) -> None:
    from cross_checks.contact.by_figure import measured
    from cross_checks.contact.request import Request

    if missing := [f"--{name}" for name, value in request.items() if value is None]:
        raise click.UsageError(f"{', '.join(missing)} must be given")
    with reported_as(click.UsageError, ValueError):
        requested = Request(**request)  # type: ignore[arg-type]
    for name, model in models.items():
        translation = model.translate(requested)
        rows = [one._asdict() for one in measured(model, requested, translation)]
        if as_json:
            parts = {"parameters": translation.parameters, "snippet": translation.snippet, "figures": rows}
            echo_json({"engine": name, "request": asdict(requested)} | parts, indent=None)
            continue
        _show(f"{name} {model.engine.version()}", rows)
        click.echo(translation.snippet)


def _violations(models: dict[str, ContactModel], cases: list[Scene], at: float, step: float, path: Path) -> list[Any]:
    """Write the contact problem of one scene at a time (s), and return the violations by all engines."""
    from cross_checks.contact import instant

    if len(cases) != 1:
        raise click.UsageError(f"--instant takes one scene, --scene SCENE; {len(cases)} are chosen")
    if not (at >= 0.0 and math.isfinite(at)):
        raise click.UsageError(f"--at {at:g}: must be at least 0")
    with reported_as(click.UsageError, ValueError, OSError, ModuleNotFoundError):
        problem = instant.instant(instant.state_at(cases[0], at), step)
        instant.write(problem, path)
    return instant.assess(problem, models.values())


def _predictions(
    models: dict[str, ContactModel], folder: Path | None, step: float, sample: int, *, each: bool
) -> Iterable[Any]:
    """Yield the predictions of every toss, or their medians by model."""
    from cross_checks.contact import tosses

    with reported_as(click.UsageError, ValueError), progress("tosses") as report:
        predicted = tosses.predict(tosses.stored(folder), models, step, sample, report)
        yield from predicted if each else tosses.summaries(predicted, random=sample > 0)


def _print(results: Iterable[Any], as_json: bool) -> None:
    """Print results as JSON lines as soon as they are known, or as a table; NothingSelected where there are none."""
    rows = map(asdict, results)
    first = next(rows, None)
    if first is None:
        raise NothingSelected("the selected scenes and engines have no figures to compare")
    if not as_json:
        return _show("", [first, *rows])
    for row in chain((first,), rows):
        echo_json(row, indent=None)


def _show(title: str, rows: list[dict[str, Any]]) -> None:
    texts = ([x if isinstance(x, str) else "-" if x is None else f"{x:.5g}" for x in row.values()] for row in rows)
    show_table(title, tuple(rows[0]), texts)
