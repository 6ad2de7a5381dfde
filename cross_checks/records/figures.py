"""Figures for a program or a notebook: each function returns a plotly figure that shows itself."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from cross_checks.records import plots
from cross_checks.records.bands import bands
from cross_checks.records.record import Record
from cross_checks.records.store import Run
from mbs_ref import Scene, Trajectory
from mbs_ref.simulate.many.ensemble import Ensemble

AXES = "xyz"


def motion(scene: Scene, path: Trajectory, bodies: Sequence[str] | None = None) -> go.Figure:
    """Return where the centres of mass of `bodies` go (m), all unless named; in space the view turns.

    ValueError where a body is unknown.
    """
    places = {name: path.position[:, _index(scene, name)] for name in bodies or scene.body_names}
    kind, layout = "scatter3d", plots.new_figure("x, m", "y, m", x_log=False, y_log=False).layout
    if scene.planar:
        kind, layout["yaxis"] = "scatter", layout["yaxis"] | {"scaleanchor": "x"}
    else:
        layout["scene"] = {"aspectmode": "data"} | {f"{a}axis": {"title": {"text": f"{a}, m"}} for a in AXES}
    data = [
        {"type": kind, "mode": "lines", "name": name, **dict(zip(AXES, place.T.tolist(), strict=False))}
        for name, place in places.items()
    ]
    return go.Figure({"data": data, "layout": layout})


def over_time(scene: Scene, path: Trajectory, body: str, quantity: str = "position") -> go.Figure:
    """Return a quantity of a body over time (s): position, orientation, velocity or angular_velocity.

    ValueError where the body or the quantity is unknown.
    """
    units = {"position": "m", "orientation": "rad" if scene.planar else "Euler parameters", "velocity": "m/s",
             "angular_velocity": "rad/s"}  # fmt: skip
    if quantity not in units:
        raise ValueError(f"quantity = {quantity!r} is unknown; allowed: {', '.join(units)}")
    values = np.reshape(getattr(path, quantity)[:, _index(scene, body)], (len(path.times), -1))
    names = ["angle"] if values.shape[1] == 1 else [f"e{k}" for k in range(4)] if values.shape[1] == 4 else list(AXES)
    figure = plots.new_figure("time, s", f"{quantity.replace('_', ' ')} of {body}, {units[quantity]}", False, False)
    for name, column in zip(names, values.T, strict=False):
        figure.add_scatter(x=path.times.tolist(), y=column.tolist(), mode="lines", name=name)
    return go.Figure(plots.to_data(figure))


def spread(ensemble: Ensemble) -> go.Figure:
    """Return how an ensemble's coordinates (m, rad) spread over time (s): 5 % to 95 %, and the median."""
    return go.Figure(plots.to_data(bands(ensemble)))


def error(runs: Iterable[Run | Record]) -> go.Figure:
    """Return the error of runs of one scene over time (s), over its scales; an engine's best run speaks for it."""
    return _of_records(plots.error_history, runs, "an error over time")


def energy(runs: Iterable[Run | Record]) -> go.Figure:
    """Return the energy that runs of one scene created or lost (J) over time (s)."""
    return _of_records(plots.energy, runs, "an energy drift over time")


def compliance(runs: Iterable[Run | Record]) -> go.Figure:
    """Return how far the joints gape (m, rad) over time (s)."""
    return _of_records(plots.compliance, runs, "a compliance over time")


def work_precision(runs: Iterable[Run | Record]) -> go.Figure:
    """Return error against the time of the loop, of runs of one scene that know their error."""
    return _of_records(plots.work_precision, runs, "an error and a time")


def _of_records(draw: Any, runs: Iterable[Run | Record], needed: str) -> go.Figure:
    records = [item.record if isinstance(item, Run) else item for item in runs]
    data = draw(records)
    if not data or not data["data"]:
        raise ValueError(f"runs = {len(records)} runs, none with {needed}; see their `status`, `message` and `notes`")
    return go.Figure(data)


def _index(scene: Scene, body: str) -> int:
    if body not in scene.body_names:
        raise ValueError(f"body = {body!r} is unknown; allowed: {', '.join(scene.body_names)}")
    return scene.body_index(body)
