"""mbs-ref animate: a scene in motion, as a GIF or an MP4 and a filmstrip."""

from pathlib import Path

import click

from cross_checks.engine import Engine
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.files import write_atomic
from reports import inputs
from reports.console import EngineAbsent, Failed, progress, reported_as


@click.command(name="animate", epilog="Example: mbs-ref animate slider_crank --engine mbs_ref -o crank.gif")
@inputs.scene_options
@click.option("--t-end", type=float, metavar="T", help="Duration, s; the scene's own unless given.")
@click.option("--frames", type=click.IntRange(2, 1000), default=81, show_default=True, help="Pictures in the GIF.")
@click.option("--strip", type=click.IntRange(1, 64), default=8, show_default=True, help="Pictures in the filmstrip.")
@click.option("--seconds", type=inputs.POSITIVE, default=4.0, show_default=True, help="It plays for.")
@click.option("--project-initial", is_flag=True, help="Project inconsistent initial conditions.")
@inputs.ENGINES
@click.option("--mp4", "video", is_flag=True, help="Write FILE.mp4 as well; needs the package av.")
@click.option("--html", "page", is_flag=True, help="Write FILE.html as well: it plays, stops and goes to any moment.")
@click.option("-o", "output", metavar="FILE.gif", help="Where to; SCENE.gif unless given. The strip is FILE.png.")
def command(
    scene: str, parameters: tuple[str, ...], t_end: float | None, frames: int, strip: int, seconds: float,
    project_initial: bool, keep_rates: tuple[str, ...], chosen: tuple[str, ...], video: bool, page: bool,
    output: str | None,
) -> None:  # fmt: skip
    """Simulate SCENE and draw it as a film or as pictures. FILE.gif plays, FILE.png shows moments side by side.

    Several --engine are drawn beside each other at the same times, each by its default method.
    """
    built = inputs.scene(scene, parameters, keep_rates)
    target = inputs.output(output or f"{built.name}.gif", (".gif",))
    assert target is not None
    settings = inputs.settings(
        t_end=t_end, samples=frames, reactions=False, estimate="off", project_initial=project_initial
    )

    from reports.film.files import as_gif, as_mp4, as_page, beside, filmstrip, video_library

    with reported_as(EngineAbsent, ImportError):
        library = video_library() if video else None

    with progress(f"animate {built.name}") as report:
        report(0, 3, "runs")
        runs = {solver.name: _run(solver, built, settings) for solver in map(inputs.engine, chosen or ("mbs_ref",))}
        report(1, 3, "is drawn, frame by frame")
        film = beside(built, runs)
        pictures = {Path(target): as_gif(film, seconds)}
        if library is not None:
            pictures[Path(target).with_suffix(".mp4")] = as_mp4(film, seconds, library)
        report(2, 3, "is drawn side by side")
        first = next(iter(runs.values()))
        if page:
            pictures[Path(target).with_suffix(".html")] = as_page(built.name, film, first.times[: len(film)], seconds)
        pictures[Path(target).with_suffix(".png")] = filmstrip(built, first, strip)
    for file, content in pictures.items():
        write_atomic(file, content)
        click.echo(str(file))
    short = [f"{name}: {path.message}" for name, path in runs.items() if not path.ok]
    if short:
        raise Failed(f"drawn as far as the runs went: {'; '.join(short)}")


def _run(solver: Engine, scene: Scene, settings: Settings) -> Trajectory:
    """Return a run that has at least two samples to draw."""
    from mbs_ref.simulate import InconsistentScene

    with reported_as(Failed, InconsistentScene):
        path = solver.run(scene, settings)
    if len(path.times) < 2:
        raise Failed(f"nothing to draw: {solver.name}: {path.status}: {path.message}")
    return path
