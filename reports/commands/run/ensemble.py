"""mbs-ref ensemble: many runs of one scene whose inputs are uncertain, or go over a grid."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.table import Table

from mbs_ref.files import write_atomic
from mbs_ref.simulate.many import ensemble as ensembles
from mbs_ref.simulate.many.ensemble import Design, Ensemble, Law, Source, Statistics, Variants, coordinates
from reports import inputs
from reports.console import Failed, Incomplete, compiling, echo_json, number, progress, reported_as, show, table
from reports.poses_file import FORMATS, write_ensemble
from reports.query import SCHEDULER, cluster
from reports.scene_summary import summary
from reports.shared_ensemble import shared_ensemble


@click.command(name="ensemble", epilog="Example: mbs-ref ensemble double_pendulum --vary angle_2=+-5% -n 500")
@click.argument("scene", metavar="SCENE|FILE.toml")
@inputs.PARAMETERS
@click.option("--vary", "varied", multiple=True, metavar="WHAT=LAW", help="A number and its law; repeatable.")
@click.option("-n", "count", type=int, metavar="N", help="Samples of the random laws.  [default: 200]")
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Of the samples.")
@inputs.run_options
@click.option("--threads", type=click.IntRange(1), metavar="N", help="Runs at once; one a processor unless given.")
@SCHEDULER
@click.option("--json", "as_json", is_flag=True, help="Print inputs, ends and statistics over time as JSON.")
@click.option("-o", "output", metavar="FILE", help="Write inputs and samples to a .npz, .csv or .parquet file.")
@click.option("--plot", metavar="FILE.html", help="Draw how the motion spreads over time, as a page.")
def command(
    scene: str, parameters: tuple[str, ...], varied: tuple[str, ...], count: int | None, seed: int, threads: int | None,
    scheduler: str | None, as_json: bool, output: str | None, plot: str | None, keep_rates: tuple[str, ...],
    **options: Any,
) -> None:  # fmt: skip
    """Run SCENE many times, with uncertain or varied numbers.

    WHAT is a parameter of the scene, or a number of it by name: link_3.mass, ball.velocity.x, load.stiffness,
    gravity.y (`mbs-ref scenes --files` writes the names). A body's position, angle (in space turn.x, turn.y, turn.z),
    velocity and angular_velocity are its start: joints, springs and contacts stay where they are on the body.

    \b
    LAW is one of
      LOW..HIGH     uniform between two bounds
      MEAN+-SD      normal; +-SD and +-P% are about the scene's own value
      LOW:HIGH:N    a grid of N even values; grids make their product

    Random laws are sampled by a Latin hypercube, the same one for the same seed.
    """
    click.get_current_context().with_resource(compiling())
    target, drawn = inputs.output(output, tuple(FORMATS)), inputs.output(plot, (".html",))
    base = inputs.scene(scene, parameters)
    chosen = inputs.settings(**options)
    with reported_as(click.UsageError, ValueError):
        variants, design = _planned(Source(base, inputs.rebuilder(scene, base)), varied, keep_rates, count, seed)
        if not as_json:
            click.echo(summary(base).sentence())
        with progress(f"ensemble {base.name}") as report, cluster(scheduler) as call:

            def shown(done: int, total: int) -> None:
                report(done, total, "")

            if call is None:
                built = ensembles.run_ensemble(variants, design, chosen, threads, shown)
            else:
                built = shared_ensemble(variants, design, chosen, call, shown)
    _write(built, target, drawn)
    if as_json:
        echo_json(ensembles.to_dict(built))
    else:
        _show(built)
    if not built.is_complete:
        raise Incomplete(f"interrupted after {len(built.statuses)} of {design.n_runs} runs")
    if np.isnan(built.reached).all():
        raise Failed(f"no run ended well; the first: {built.statuses[0]}: {built.messages[0]}")


def _planned(
    source: Source, varied: tuple[str, ...], keep_rates: tuple[str, ...], count: int | None, seed: int
) -> tuple[Variants, Design]:
    """Return what is varied and by which values; ValueError says what cannot be."""
    if not varied:
        raise ValueError(f"nothing is varied; give --vary WHAT=LAW, where LAW is {ensembles.NOTATION}")
    laws: dict[str, Law] = {}
    targets = []
    for words in varied:
        name, equals, law = words.partition("=")
        if not name or not equals:
            raise ValueError(f"--vary {words}: must be WHAT=LAW, where LAW is {ensembles.NOTATION}")
        if name in laws:
            raise ValueError(f"--vary {name} is given twice")
        try:
            targets.append(source.target(name))
            laws[name] = ensembles.read_law(law, targets[-1].own)
        except ValueError as error:
            raise ValueError(f"--vary {words}: {error}") from error
    return Variants(source, targets, keep_rates), ensembles.design(laws, count, seed)


def _write(built: Ensemble, target: Path | None, drawn: Path | None) -> None:
    if target is not None:
        write_ensemble(built, target)
    if drawn is not None:
        from cross_checks.records.bands import bands

        write_atomic(drawn, bands(built).to_html().encode())


def _show(built: Ensemble) -> None:
    result = ensembles.statistics(built)
    for name, law in built.design.laws.items():
        click.echo(f"{name}: {law}")
    if built.ended_well.any():
        listing, more = end_table(built, result)
        show(listing)
        if more:
            click.echo(f"and {more} rows more: --json, -o and --plot have them")
        click.echo()
    for sentence in ensembles.account(built, result):
        click.echo(sentence)
    click.echo(f"{number(built.runs_per_s)} runs/s, {number(built.wall_s)} s in all, error estimates included")


MOST_ROWS = 60


def end_table(ensemble: Ensemble, result: list[Statistics | None]) -> tuple[Table, int]:
    """Return the figures at the end, and how many rows of them there is no room for."""
    title = f"\nAt t = {ensemble.times[-1]:g} s"
    grids = tuple(ensemble.design.grids)
    if ensemble.design.is_random:
        columns = ("mean", "std. error", "std. deviation", "std. error", "5 %", "median", "95 %", "smallest", "largest")
        rows = list(_spreads(ensemble, result))
        listing = table(title, *grids, "body", "", *columns)
    else:
        rows = list(_ends(ensemble, result))
        listing = table(title, *grids, "body", *dict.fromkeys(f"{x.name}, {x.unit}" for x in coordinates(ensemble)))
    for row in rows[:MOST_ROWS]:
        listing.add_row(*row)
    return listing, max(0, len(rows) - MOST_ROWS)


def _spreads(ensemble: Ensemble, result: list[Statistics | None]) -> Iterator[tuple[str, ...]]:
    """Yield a row a point of the grids and coordinate."""
    for at, one in _points(ensemble, result):
        if one is None:
            yield *at, "no run ended well"
            continue
        for k, place in enumerate(coordinates(ensemble)):
            spread, middle = one.deviation[-1, k], one.mean[-1, k]
            figures = _figures(middle, spread)
            values = (middle, *one.quantiles[:, -1, k], one.least[-1, k], one.most[-1, k])
            mean, *others = (_significant(value, figures) for value in values)
            yield (
                *at, place.body, f"{place.name}, {place.unit}", mean, number(one.mean_error[-1, k]),
                _significant(spread), number(one.deviation_error[-1, k]), *others,
            )  # fmt: skip


def _ends(ensemble: Ensemble, result: list[Statistics | None]) -> Iterator[tuple[str, ...]]:
    """Yield a row a point of the grids and body, of a single run each."""
    for (at, one), status in zip(_points(ensemble, result), ensemble.statuses, strict=False):
        if one is None:
            yield *at, str(status)
            continue
        ends: dict[str, list[str]] = {}
        for place, value in zip(coordinates(ensemble), one.mean[-1], strict=True):
            ends.setdefault(place.body, []).append(_significant(value, 9))
        yield from ((*at, body, *values) for body, values in ends.items())


def _points(ensemble: Ensemble, result: list[Statistics | None]) -> Iterator[tuple[list[str], Statistics | None]]:
    for at, one in zip(ensemble.design.points, result, strict=True):
        yield [f"{value:.6g}" for value in at], one


def _figures(value: float, spread: float) -> int:
    """Return how many figures of a value show its spread with two, six at least."""
    if not spread > 0.0 or value == 0.0:
        return 6
    return int(np.clip(np.ceil(np.log10(abs(value) / spread)) + 2, 6, 12))


def _significant(value: float, count: int = 6) -> str:
    return f"{value:.{count}g}"
