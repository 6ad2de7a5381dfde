"""mbs-ref simulate: one run, judged."""

from collections.abc import Iterable, Iterator
from typing import Any

import click
import numpy as np

from cross_checks import metrics
from cross_checks.metrics.errors import COMPONENTS
from cross_checks.metrics.metric import Metric
from cross_checks.records.record import Record
from cross_checks.records.store import Run, Store
from mbs_ref import Scene, Trajectory
from reports import console, inputs
from reports.console import text_plot
from reports.poses_file import FORMATS, write_poses
from reports.query import STORE, store_path
from reports.scene_summary import summary

ENDED = ("success", "stop-event")  # statuses of a run that came to its end


@click.command(
    name="simulate", epilog="Example: mbs-ref simulate slider_crank -p crank_length=0.2 --rtol 1e-9 -o run.csv"
)
@click.argument("scene", metavar="SCENE|FILE.toml")
@inputs.PARAMETERS
@click.option("--engine", default="mbs_ref", show_default=True, help="Engine that integrates.")
@inputs.run_options
@click.option("--stop-on-compliance", is_flag=True, help="End the run where |C(q, t)| < step fails (the papers' test).")
@click.option("--no-truth", is_flag=True, help="Compare with no truth: computing the first may take a minute.")
@click.option("--json", "as_json", is_flag=True, help="Print the whole record as JSON.")
@click.option("--plot", is_flag=True, help="Draw the last body's path and the error over time, in characters.")
@click.option("-o", "output", metavar="FILE", help="Write times and poses to a .npz, .csv or .parquet file.")
@STORE
def command(
    scene: str, parameters: tuple[str, ...], engine: str, method: str | None, output: str | None, as_json: bool,
    no_truth: bool, store: str | None, plot: bool, keep_rates: tuple[str, ...], **options: Any,
) -> None:  # fmt: skip
    """Simulate SCENE and judge the result against its truth.

    The result is printed at once, then its error. A truth is computed once and stored.
    """
    click.get_current_context().with_resource(console.compiling())
    target = inputs.output(output, tuple(FORMATS))
    chosen_scene = inputs.scene(scene, parameters, keep_rates)
    chosen = inputs.settings(method=method, **options)
    solver = inputs.engine(engine)
    chosen = chosen.model_copy(update={"method": inputs.method(solver, method or solver.default_method)})

    if not as_json:
        click.echo(summary(chosen_scene).sentence())

    from cross_checks.judge import one_run as compare
    from cross_checks.judge.runs import NOT_COMPARED

    record, trajectory = compare.judged_run(chosen_scene, solver.name, chosen, truth=NOT_COMPARED)
    if target is not None and trajectory is not None and record.status in (*ENDED, "interrupted"):
        write_poses(trajectory, chosen_scene.body_names, target)
    if not as_json:
        _show(record)
    if trajectory is not None and not no_truth and record.status in ENDED:
        text = len(record.notes)
        record = _judged(chosen_scene, record, trajectory, store)
        if not as_json:
            _show_error(record, record.notes[text:])
    if as_json:
        console.echo_json(record.to_dict())
    if trajectory is not None and not as_json:
        _show_path(chosen_scene, trajectory, record, plot)
    if record.status == "engine-missing":
        raise console.EngineAbsent(record.message)
    if record.status in ("interrupted", "out-of-memory"):
        raise console.Incomplete(record.message)
    if record.status not in ENDED:
        raise console.Failed(f"{record.status}: {record.message}")


def _judged(scene: Scene, record: Record, path: Trajectory, store: str | None) -> Record:
    """Return the record with its error from the scene's truth, which the store keeps."""
    from cross_checks.judge.runs import Runs, against

    with (
        Store(store_path(store)) as opened,
        console.awaited(f"computing the truth of {scene.name}, once: --no-truth omits it"),
    ):
        truth = Runs(opened).truth(scene, path.times)
    return against(scene, Run(record, path), truth)


def _show_path(scene: Scene, path: Trajectory, record: Record, plot: bool) -> None:
    if open_all_along := never_closed(path):
        named = ", ".join(open_all_along[:MOST_NAMED]) + (" ..." if len(open_all_along) > MOST_NAMED else "")
        click.echo(f"Never closed in {path.times[-1]:g} s, of {len(path.contacts)} contacts: {named}")
    if plot and len(path.times) > 1:
        click.echo(f"\n{run_plot(scene, path, record)}")


MOST_NAMED = 6  # contacts that never closed
MOST_TIMES = 12  # of a declared event that are printed; --json has them all


def _show(record: Record) -> None:
    rows = [
        ("status", f"{record.status} {record.message}".rstrip()),
        ("reached", f"{record.t_end:g} s in {record.steps} steps, {record.rhs_calls} right-hand sides"),
        *([] if record.estimate is None else [("estimated error", _estimate(record.estimate))]),
        *_figures(record, metrics.every().values()),
        ("times", ", ".join(f"{key} {console.number(value)}" for key, value in record.times.items())),
        *((name, console.number(value)) for name, value in record.contact.items()),
        *((f"event {name}", f"{len(times)}: {_digits(times[:MOST_TIMES])} s" if times else "never")
          for name, times in record.events.items()),
        *(("note", note) for note in record.notes),
    ]  # fmt: skip
    console.show_table(f"{record.scene} by {record.engine}, {record.method}", ("", ""), rows)
    states = record.final.items()
    poses = ((body, s.get("position"), s.get("angle", s.get("orientation")), s.get("velocity")) for body, s in states)
    head = ("body", "position, m", "angle or orientation", "velocity, m/s")
    console.show_table("\nAt the end", head, ((body, *map(_digits, values)) for body, *values in poses))


def _show_error(record: Record, notes: tuple[str, ...]) -> None:
    """Show what the truth tells of the run, with the notes that came of it."""
    error, rows = record.error, [("error", "no truth known")]
    if error is not None:
        off = console.amount(error.value if error.is_judged else None, "of the scene", error.bound)
        known = f"{console.number(error.uncertainty)} of the scene, whose length is {console.number(error.length)} m"
        rows = [("error", f"{off} ({error.worst})"), ("truth", f"{error.truth}, known to {known}")]
    rows += [*_figures(record, COMPONENTS), *(("note", note) for note in notes)]
    if error is None:
        rows.append(("next", "mbs-ref check computes a consensus truth from unlike engines, and judges by it"))
    console.show_table("\nAgainst the truth", ("", ""), rows)


def _figures(record: Record, listed: Iterable[Metric]) -> Iterator[tuple[str, str]]:
    for metric in listed:
        if figure := console.amount(record.measure(metric.name), metric.unit, record.bounds.get(metric.name)):
            yield metric.label, figure


def _estimate(estimate: dict[str, Any]) -> str:
    value = "not bounded" if estimate["value"] is None else f"{console.number(estimate['value'])} {estimate['unit']}"
    return f"{value}: {estimate['how']}; it took {console.number(estimate['cost_s'])} s"


def _digits(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_digits(item) for item in value)
    return "-" if value is None else f"{value:.15g}"


AXES = "xyz"


def run_plot(scene: Scene, path: Trajectory, record: Record) -> str:
    """Return the plots, one above the other."""
    body = scene.body_names[-1]
    places = {f"{AXES[k]} of {body}": (path.times, path.position[:, -1, k]) for k in range(path.position.shape[2])}
    plots = [text_plot(places, "t, s", "position, m")]
    error = np.array(record.history.get("error", []), dtype=float)
    if len(error):
        over_time = {"error": (path.times[1 : len(error)], error[1:])}  # which begins at 0 by construction
        plots.append(text_plot(over_time, "t, s", "error over the scene's scales", log_y=True))
    return "\n\n".join(plot for plot in plots if plot)


def never_closed(path: Trajectory) -> list[str]:
    """Return the contacts that are open at every output, and at no event: a floor on the wrong side is one of them."""
    met = set() if path.event_times is None else {path.event_names[int(k)] for k in path.event_times[:, 1]}
    return [name for name, history in path.contacts.items() if name not in met and not np.any(history[:, 0] > 0.0)]
