"""A run in the terminal: where its last body goes, and its error over time."""

from __future__ import annotations

import numpy as np

from cross_checks.records.record import Record
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory
from reports.terminal.text_plot import text_plot

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
