"""mbs-ref write SCENE: a scene as a robot file, or as a script that runs in one engine alone."""

from pathlib import Path
from typing import Any

import click

from cross_checks import writers
from cross_checks.engines import EngineMissing
from mbs_ref.files import write_atomic
from reports import inputs
from reports.console import EngineAbsent, Failed, reported_as


@click.command(name="write", epilog="Example: mbs-ref write n_four_bar --as exudyn -o loops.py")
@click.argument("scene", metavar="SCENE|FILE")
@click.option("--as", "form", required=True, metavar="FORM",
              help="mjcf, urdf, or an engine whose script is wanted: drake, exudyn, mujoco, pinocchio.")  # fmt: skip
@inputs.PARAMETERS
@click.option("--method", help="How a script integrates; the engine's default unless given.")
@click.option("--step", type=float, metavar="H", help="Step of a fixed-step method, s.")
@click.option("--rtol", type=float, metavar="R", help="Relative tolerance of an adaptive method.")
@click.option("--atol", type=float, metavar="A", help="Absolute tolerance; rtol unless given.")
@click.option("--t-end", type=float, metavar="T", help="Duration, s; the scene's own unless given.")
@click.option("--samples", type=int, metavar="N", help="Output times, evenly spaced from 0 to the end.")
@inputs.KEEP
@click.option("-o", "output", metavar="FILE", help="Where to write; stdout unless given.")
def command(
    scene: str, form: str, parameters: tuple[str, ...], keep_rates: tuple[str, ...], output: str | None, **options: Any
) -> None:
    """Write SCENE as a file that runs without mbs-ref.

    A script needs only its engine, NumPy and for some methods SciPy. It prints the poses that the adapter computes, up
    to roundoff, and is run once to its end before it is written. What the form cannot represent is refused by name.
    """
    target = None if output is None else inputs.output(output, (_form(form).suffix,))
    chosen = inputs.scene(scene, parameters, keep_rates)
    settings = inputs.settings(**options)
    with (
        reported_as(click.UsageError, ValueError), reported_as(Failed, writers.NotWritable),
        reported_as(EngineAbsent, EngineMissing),
    ):  # fmt: skip
        text = writers.write(chosen, _form(form).name, settings)
    if target is None:
        click.echo(text, nl=False)
        return
    write_atomic(Path(target), text.encode())
    click.echo(target)


def _form(name: str) -> writers.Form:
    known = writers.forms()
    if name not in known:
        raise click.UsageError(f"--as {name}: unknown; allowed: {', '.join(known)}")
    return known[name]
