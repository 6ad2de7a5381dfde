"""mbs-ref ensemble: many runs of one scene whose inputs are uncertain, or go over a grid."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from mbs_ref.atomic_file import write_atomic
from mbs_ref.simulate.many import ensemble as ensembles
from mbs_ref.simulate.many.ensemble import Design, Ensemble, Law, Source, Variants
from reports import inputs
from reports.poses_file import ENSEMBLE_FORMATS, write_ensemble
from reports.scene_summary import summary
from reports.terminal.console import compiling, echo_json, number, progress, show
from reports.terminal.ensemble_tables import end_table
from reports.terminal.exit_codes import Failed, Incomplete


@click.command(name="ensemble")
@click.argument("scene", metavar="SCENE|FILE.toml")
@inputs.PARAMETERS
@click.option("--vary", "varied", multiple=True, metavar="WHAT=LAW", help="A number and its law; repeatable.")
@click.option("-n", "count", type=int, metavar="N", help="Samples of the random laws.  [default: 200]")
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Of the samples.")
@inputs.run_options
@click.option("--threads", type=click.IntRange(1), metavar="N", help="Runs at once; one a processor unless given.")
@click.option("--json", "as_json", is_flag=True, help="Print inputs, ends and statistics over time as JSON.")
@click.option("-o", "output", metavar="FILE", help="Write inputs and samples to a .npz, .csv or .parquet file.")
@click.option("--plot", metavar="FILE.html", help="Draw how the motion spreads over time, as a page.")
def command(
    scene: str,
    parameters: tuple[str, ...],
    varied: tuple[str, ...],
    count: int | None,
    seed: int,
    threads: int | None,
    as_json: bool,
    output: str | None,
    plot: str | None,
    kept: tuple[str, ...],
    **options: Any,
) -> None:
    """Run SCENE many times, with numbers that are uncertain or go over a grid.

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
    target, drawn = inputs.output(output, tuple(ENSEMBLE_FORMATS)), inputs.output(plot, (".html",))
    base = inputs.scene(scene, parameters)
    chosen = inputs.settings(**options)
    try:
        variants, design = _planned(Source(base, inputs.rebuilder(scene, base)), varied, kept, count, seed)
        if not as_json:
            click.echo(summary(base).sentence())
        with progress(f"ensemble {base.name}") as report:
            made = ensembles.run_ensemble(variants, design, chosen, threads, lambda done, all_: report(done, all_, ""))
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    _write(made, target, drawn, output, plot)
    if as_json:
        echo_json(ensembles.to_dict(made))
    else:
        _show(made)
    if not made.is_complete:
        raise Incomplete(f"interrupted after {len(made.statuses)} of {design.n_runs} runs")
    if np.isnan(made.reached).all():
        raise Failed(f"no run ended well; the first: {made.statuses[0]}: {made.messages[0]}")


def _planned(
    source: Source, varied: tuple[str, ...], kept: tuple[str, ...], count: int | None, seed: int
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
    return Variants(source, targets, kept), ensembles.design(laws, count, seed)


def _write(made: Ensemble, target: Path | None, drawn: Path | None, output: str | None, plot: str | None) -> None:
    try:
        if target is not None:
            write_ensemble(made, target)
        if drawn is not None:
            from reports.drawing.plots.bands import bands

            write_atomic(drawn, bands(made).to_html().encode())
    except OSError as error:
        raise Failed(f"{output or plot}: cannot be written: {error.strerror}") from error


def _show(made: Ensemble) -> None:
    found = ensembles.statistics(made)
    for name, law in made.design.laws.items():
        click.echo(f"{name}: {law}")
    if made.ended_well.any():
        listing, more = end_table(made, found)
        show(listing)
        if more:
            click.echo(f"and {more} rows more: --json, -o and --plot have them")
        click.echo()
    for sentence in ensembles.account(made, found):
        click.echo(sentence)
    click.echo(f"{number(made.runs_per_s)} runs/s, {number(made.wall_s)} s in all, error estimates included")
