"""Energy balance across contact events: the work is integrated piece by piece, each piece smooth.

A run's events and breakpoints cut time into panels; a second run is sampled at the Gauss-Legendre points inside
them, so that no panel holds a kink and no sample lies on one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.energy import is_conservative, kinetic_energy, potential_energy
from mbs_ref.observables.powers import powers
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

POINTS = 3  # of Gauss and Legendre in a panel: exact for a power of degree 5
APART = 1e-9  # s: events closer than this share a panel's edge


@dataclass(frozen=True)
class Balance:
    """Energy and work at the edges of the panels."""

    times: np.ndarray  # (n,) s
    energy: np.ndarray  # (n,) J, kinetic + potential
    work: np.ndarray  # (n,) J, since t = 0, of contacts, dampers and drives
    exchanged: float  # J, the integral of |power|: what the drift is to be compared with

    @property
    def drift(self) -> np.ndarray:
        return self.energy - self.energy[0] - self.work


def balance(scene: Scene, settings: Settings, longest: float) -> Balance:
    """Run twice and balance the energy; panels are `longest` (s) at most. ValueError where a run fails."""
    run = _good(simulate(scene, settings.model_copy(update={"reactions": False})))
    edges = _edges(scene, run, longest)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    width = np.diff(edges)
    inside = edges[:-1, None] + 0.5 * width[:, None] * (1.0 + points)
    every = np.unique(np.concatenate((edges, inside.ravel())))
    path = _good(simulate(scene, settings.model_copy(update={"reactions": True}), every))  # with contact forces
    power = powers(Motion(scene, path), is_conservative)
    if power is None:
        power = np.zeros(len(path.times))
    at = np.searchsorted(path.times, inside)
    steps = 0.5 * width * (power[at] @ weights)
    energy = (kinetic_energy(scene, path) + potential_energy(scene, path))[np.searchsorted(path.times, edges)]
    exchanged = float(np.sum(0.5 * width * (np.abs(power[at]) @ weights)))
    return Balance(edges, energy, np.concatenate(([0.0], np.cumsum(steps))), exchanged)


def _good(path: Trajectory) -> Trajectory:
    if not path.ok:
        raise ValueError(f"no energy balance: {path.message}")
    return path


def _edges(scene: Scene, path: Trajectory, longest: float) -> np.ndarray:
    end = float(path.times[-1])
    events = np.zeros(0) if path.event_times is None else path.event_times[:, 0]
    cuts = np.concatenate((events, scene.breakpoints(), np.linspace(0.0, end, int(np.ceil(end / longest)) + 1)))
    cuts = np.unique(cuts[(cuts > APART) & (cuts < end - APART)])
    kept = cuts[np.concatenate(([True], np.diff(cuts) > APART))] if len(cuts) else cuts
    return np.concatenate(([0.0], kept, [end]))
