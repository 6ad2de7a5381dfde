"""mbs-ref animate: a scene in motion, as a GIF and a filmstrip."""

from __future__ import annotations

from pathlib import Path

import click

from mbs_ref.atomic_file import write_atomic
from reports import inputs
from reports.terminal.console import progress
from reports.terminal.exit_codes import Failed


@click.command(name="animate")
@click.argument("scene", metavar="SCENE|FILE.toml")
@click.option("-p", "parameters", multiple=True, metavar="NAME=VALUE", help="A parameter of the scene; repeatable.")
@click.option("--t-end", type=float, metavar="T", help="Duration, s; the scene's own unless given.")
@click.option("--frames", type=click.IntRange(2, 1000), default=81, show_default=True, help="Pictures in the GIF.")
@click.option("--strip", type=click.IntRange(1, 64), default=8, show_default=True, help="Pictures in the filmstrip.")
@click.option("--seconds", type=float, default=4.0, show_default=True, callback=inputs.positive, help="It plays for.")
@click.option("--project-initial", is_flag=True, help="Repair inconsistent initial conditions.")
@inputs.KEEP
@click.option("-o", "output", metavar="FILE.gif", help="Where to; SCENE.gif unless given. The strip is FILE.png.")
def command(
    scene: str, parameters: tuple[str, ...], t_end: float | None, frames: int, strip: int, seconds: float,
    project_initial: bool, kept: tuple[str, ...], output: str | None,
) -> None:  # fmt: skip
    """Simulate SCENE with mbs_ref and draw it: FILE.gif plays, FILE.png shows moments side by side."""
    chosen = inputs.keeping(inputs.scene(scene, parameters), kept)
    target = inputs.output(output or f"{chosen.name}.gif", (".gif",))
    assert target is not None
    settings = inputs.settings(
        t_end=t_end, samples=frames, reactions=False, estimate="off", project_initial=project_initial
    )  # fmt: skip

    from mbs_ref.simulate import InconsistentScene, simulate
    from reports.film import filmstrip, gif

    with progress(f"animate {chosen.name}") as report:
        report(0, 3, "runs")
        try:
            path = simulate(chosen, settings)
        except InconsistentScene as error:
            raise Failed(str(error)) from error
        if len(path.times) < 2:
            raise Failed(f"nothing to draw: {path.status}: {path.message}")
        report(1, 3, "is drawn, frame by frame")
        pictures = {Path(target): gif(chosen, path, seconds)}
        report(2, 3, "is drawn side by side")
        pictures[Path(target).with_suffix(".png")] = filmstrip(chosen, path, strip)
    for file, content in pictures.items():
        try:
            write_atomic(file, content)
        except OSError as error:
            raise Failed(f"{file} cannot be written: {error.strerror}") from error
        click.echo(str(file))
    if not path.ok:
        raise Failed(f"drawn as far as the run went: {path.message}")
