"""States and step counts of an OpenSim model, and Simbody's integrators as OpenSim offers them."""

import ctypes
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
import opensim

from cross_checks.engine import RTOLS, STEPS, Method
from cross_checks.linkage.links import Linkage

FIXED = "_fixed"
SHORTEST = 2e-8  # of a run: no step is shorter, whatever its error, for 5e7 steps are the most that a run may take
ENDLESS = "cpodes"  # in loops: no limit on steps ends it (seen in 4.6 on spatial_n_four_bar at 1e-8)
INTEGRATORS = {
    "rk_merson": "RungeKuttaMerson",
    "rk_feldberg": "RungeKuttaFeldberg",
    "rk3": "RungeKutta3",
    "verlet": "Verlet",
    "cpodes": "CPodes",
}
METHODS = (
    Method("rk_merson", "adaptive", 4, "OpenSim's default: Runge-Kutta-Merson", RTOLS, embedded=3),
    Method("rk_feldberg", "adaptive", 5, "Runge-Kutta-Fehlberg", RTOLS),
    Method("rk3", "adaptive", 3, "Runge-Kutta 3 with an embedded estimate", RTOLS, embedded=2),
    Method("verlet", "adaptive", 2, "velocity Verlet", RTOLS[:4]),
    Method("cpodes", "adaptive", None, "CPODES: variable-order BDF", RTOLS),
    Method("rk_merson" + FIXED, "fixed", 4, "Runge-Kutta-Merson at a fixed step", STEPS),
)


def values(state: Any) -> np.ndarray:
    """Return a copy of Simbody's state vector."""
    return np.array(state.getY().to_numpy())


class Reader:
    """Reads state vectors in a state of its own."""

    def __init__(self, linkage: Linkage, model: Any, joints: list[Any], state: Any) -> None:
        self.model, self.state = model, opensim.State(state)
        self.bodies = [model.getBodySet().get(link.name) for link in linkage.of_body]
        self.centres = np.array([link.centre for link in linkage.of_body])
        self.counted = [
            joint.get_coordinates(k)
            for joint, link in zip(joints, linkage.links, strict=True)
            for k in ((1, 2, 0) if link.kind == "planar" else range(link.size))[: link.size]  # it turns, then slides
        ]

    def _put(self, state: np.ndarray) -> None:
        self.state.setY(opensim.Vector.createFromMat(state))
        self.model.realizeVelocity(self.state)

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self._put(state)
        places = [coordinate.getValue(self.state) for coordinate in self.counted]
        return np.array(places), np.array([coordinate.getSpeedValue(self.state) for coordinate in self.counted])

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        self._put(state)
        placed = [body.getTransformInGround(self.state) for body in self.bodies]
        moving = [body.getVelocityInGround(self.state) for body in self.bodies]
        turns = [place.R().asMat33() for place in placed]
        turn = np.array([[[matrix.get(i, j) for j in range(3)] for i in range(3)] for matrix in turns])
        omega = np.array([velocity.get(0).to_numpy() for velocity in moving])
        arm = np.einsum("nij,nj->ni", turn, self.centres)
        centre = np.array([place.p().to_numpy() for place in placed]) + arm
        speed = np.array([velocity.get(1).to_numpy() for velocity in moving]) + np.cross(omega, arm)
        return turn, centre, speed, omega


LEVEL = "Error"  # of what OpenSim prints otherwise


class Counts(NamedTuple):
    """Of all integrations since the manager was initialized; zeros where the log does not tell."""

    steps: int = 0
    rhs_calls: int = 0
    rejected_steps: int = 0


def counted(manager: Any, t: float) -> tuple[Any, Counts]:
    """Integrate to time t (s); return the state, and what was counted since the manager was initialized.

    What OpenSim prints beside its log is kept from standard output.
    """
    sink = opensim.StringLogSink()
    opensim.Logger.removeFileSink()
    opensim.Logger.addSink(sink)
    with _unprinted():
        opensim.Logger.setLevelString("Info")
        try:
            state = manager.integrate(t)
        finally:
            opensim.Logger.setLevelString(LEVEL)
            opensim.Logger.removeSink(sink)
    return state, _read(sink.getString())


def _read(log: str) -> Counts:
    steps = re.search(r"steps taken / attempted: (\d+) / (\d+)", log)
    calls = re.search(r"number of realizations: (\d+)", log)
    if steps is None or calls is None:
        return Counts()
    taken, attempted = map(int, steps.groups())
    return Counts(taken, int(calls[1]), attempted - taken)


@contextmanager
def _unprinted() -> Iterator[None]:
    """Send what the process prints to nowhere, native code's prints among it."""
    flush = ctypes.CDLL(None).fflush
    sys.stdout.flush()
    flush(None)
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    try:
        yield
    finally:
        flush(None)
        os.dup2(kept, 1)
        os.close(kept)
