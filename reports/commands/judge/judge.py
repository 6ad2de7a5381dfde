"""mbs-ref judge: any tool's trajectory compared with the truth of a scene, or with another file."""

from pathlib import Path

import click

from cross_checks import metrics
from cross_checks.records.plots import FLOOR, new_figure
from cross_checks.trajectory_files.judgement import Judgement
from mbs_ref import Scene
from mbs_ref.files import write_atomic
from reports import console, inputs
from reports.query import STORE, open_runs

MAP = click.Path(path_type=Path)


@click.command(name="judge", epilog="Example: mbs-ref judge run.csv pendulum --map map.toml --error 1e-4")
@click.argument("file", metavar="FILE")
@inputs.scene_options
@click.option(
    "--map", "map_file", type=MAP, metavar="MAP.toml", help="What the columns mean; files of simulate -o need none."
)
@click.option("--write-map", metavar="MAP.toml", help="Write a map to be filled in, and judge nothing.")
@click.option("--against", metavar="OTHER", help="Compare FILE with this file, not with the scene's truth.")
@click.option("--against-map", type=MAP, metavar="MAP.toml", help="The map of OTHER; --map unless given.")
@click.option(
    "--error", "wanted", default="1e-6", show_default=True, metavar="E",
    help="What counts as agreement: a share of the scene, or a length as 1mm.",
)  # fmt: skip
@click.option("--t-end", type=inputs.POSITIVE, metavar="T", help="Duration, s; the scene's own.")
@click.option("--plot", metavar="FILE.html", help="Write the error over time, component by component.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@STORE
def command(
    file: str, scene: str, parameters: tuple[str, ...], keep_rates: tuple[str, ...], map_file: Path | None,
    write_map: str | None, against: str | None, against_map: Path | None, wanted: str, t_end: float | None,
    plot: str | None, as_json: bool, store: str | None,
) -> None:  # fmt: skip
    """Judge the trajectory in FILE, which any tool may write. It is CSV, NPZ or Parquet.

    Every unit, axis and convention of the file is stated in a map; none is guessed. Errors are those of every table:
    position, orientation, velocity and angular velocity of every body over the scene's own scales. Where the file is
    off, mistakes that would explain it are fitted: units, conventions, frames, reference points, clocks, and numbers of
    the scene. Exit code 1 where it is off by more than --error, 5 where there is no truth to judge it.
    """
    from cross_checks.trajectory_files.formats import FileError
    from cross_checks.trajectory_files.judgement import as_truth, judgement
    from cross_checks.trajectory_files.library import judged, truth_at
    from cross_checks.trajectory_files.motion import in_common, read_motion

    chosen = inputs.comparable(scene, parameters, keep_rates)
    if t_end is not None:
        chosen = chosen.model_copy(update={"duration": t_end})
    limit = inputs.relative_error(wanted, chosen)
    drawing = inputs.output(plot, (".html",))
    with console.reported_as(click.UsageError, FileError):
        if write_map is not None:
            return _begin_map(Path(file), chosen, write_map)
        with open_runs([chosen], store) as runs, console.progress(f"reading rows of {file}") as report:
            if against is None:
                read = read_motion(Path(file), chosen, map_file, report=report)
                with console.awaited(f"computing the truth of {chosen.name} at the times of {file}, once"):
                    result = judged(chosen, read, truth_at(runs, chosen), limit)
            else:
                files = (Path(file), map_file), (Path(against), against_map or map_file)
                ours, theirs = in_common(chosen, files, report)
                result = judgement(chosen, *as_truth(chosen, ours, theirs, Path(against).name), limit)
    if drawing is not None:
        _draw(result, drawing)
    _answer(result, as_json)


def _begin_map(file: Path, scene: Scene, target: str) -> None:
    from cross_checks.trajectory_files.column_map import blank_map
    from cross_checks.trajectory_files.columns import read_header
    from cross_checks.trajectory_files.formats import FileError

    place = inputs.output(target, (".toml",))
    assert place is not None
    if place.exists():
        raise FileError(f"--write-map {place}: exists already")
    names = list(read_header(file).values)
    write_atomic(place, blank_map(names, list(scene.body_names), scene.dimension).encode())
    click.echo(f"{place} holds a map to be filled in for {len(names)} columns and {len(scene.bodies)} bodies", err=True)


def _answer(result: Judgement, as_json: bool) -> None:
    console.answer(result.to_dict(), None, as_json, lambda _: _show(result))
    if result.verdict == "departs":
        raise console.Failed(f"{result.verdict}: {result.reason}")
    if result.verdict == "not-judged":
        raise console.NothingSelected(f"not judged: {result.reason}")


def _show(result: Judgement) -> None:
    facts = [("verdict", f"{result.verdict}: {result.reason}")]
    if result.error is not None:
        known, length = map(console.number, (result.error.uncertainty, result.error.length))
        facts.append(("compared with", result.error.truth))
        facts.append(("known to", f"{known} of the scene; the scene's length is {length} m"))
    facts += [("suspicion", sentence) for sentence in result.suspicions]
    known_ones = ((metric, result.measures.get(name)) for name, metric in metrics.every().items())
    facts += [(metric.label, console.amount(value, metric.unit)) for metric, value in known_ones if value is not None]
    facts += [("note", sentence) for sentence in (*result.missing, *result.notes)]
    console.show_table(result.scene, ("", ""), facts)
    rows = []
    for part in result.parts:
        size = console.amount(part.largest, part.unit, part.below) or "unknown"
        rows.append((part.body, part.component, size, *map(console.number, (part.relative, part.at, part.final))))
    console.show_table("\nErrors", ("body", "component", "largest", "of the scene", "at t, s", "at the end"), rows)


def _draw(result: Judgement, target: Path) -> None:
    figure = new_figure("time, s", "error over the scene's scales", x_log=False)
    times = result.curves.get("t", [])
    for name, curve in result.curves.items():
        if name != "t" and any(curve):
            sizes = [None if value is None else max(value, FLOOR) for value in curve]
            figure.add_scatter(x=times, y=sizes, name=name, mode="lines+markers")
    write_atomic(target, figure.to_html(include_plotlyjs=True).encode())
