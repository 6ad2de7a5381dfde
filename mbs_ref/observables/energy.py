"""Energy, and the balance E(t) - E(0) = work of everything that is not conservative."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from mbs_ref import scene as parts
from mbs_ref.observables import celestial
from mbs_ref.observables.attachment import Motion, bushing_strain, gap_of, length_of, pull_of, twist_of
from mbs_ref.observables.momentum import spins
from mbs_ref.observables.powers import powers
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import GravityGradient, Newton
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.joints import Drive, UserConstraint
from mbs_ref.scene.scales import is_celestial
from mbs_ref.scene.signals import Constant, Signal
from mbs_ref.scene.traits import touching
from mbs_ref.trajectory import Trajectory


@dataclass(frozen=True)
class EnergyBalance:
    """Energy along a motion; `drift` is None where no balance can be drawn.

    `reason` states why, and is empty where samples are incomplete.
    """

    energy: np.ndarray  # (n_t,) J, kinetic + potential
    work: np.ndarray | None  # (n_t,) J, done since t = 0 by dampers, time-dependent loads and user forces
    drift: np.ndarray | None  # (n_t,) J, energy - energy[0] - work
    resolution: float  # J, how well the samples resolve the work
    reason: str = ""


@np.errstate(over="ignore", invalid="ignore")
def kinetic_energy(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return the kinetic energy (n_t,), J; infinite or NaN where a run that diverged is beyond squares."""
    mass = np.array([body.mass for body in scene.bodies])
    return 0.5 * np.sum(trajectory.velocity**2, axis=2) @ mass + _rotation(scene, trajectory)


def _rotation(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return sum(omega . J omega) / 2 of all bodies but particles (n_t,), J."""
    turns = np.array([not isinstance(body, PointMass) for body in scene.bodies], dtype=bool)
    omega, own = trajectory.angular_velocity[:, turns], spins(scene, trajectory)[:, turns]
    return 0.5 * np.sum((omega * own).reshape(len(omega), -1), axis=1)


def potential_energy(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return the potential energy (n_t,), J: gravity, springs, and forces and torques that never change."""
    mass = np.array([body.mass for body in scene.bodies])
    motion = Motion(scene, trajectory)
    total = -(trajectory.position @ np.asarray(scene.gravity)) @ mass
    for load in scene.loads:
        if is_conservative(load):
            total = total + POTENTIALS[type(load)](motion, load)
    return total


def is_conservative(load) -> bool:
    """Return whether the load has a potential (its damping apart): it does not change, nor turn with its body."""
    steady = all(isinstance(signal, Constant) for signal in load.signals)
    return type(load) in POTENTIALS and steady and getattr(load, "frame", "world") == "world"


@np.errstate(over="ignore", invalid="ignore")
def energy_balance(scene: Scene, trajectory: Trajectory) -> EnergyBalance:
    """Return energy and its drift after the work of all that is not conservative, integrated over the samples.

    Fourth-order splines integrate the power; comparing with every second sample gives `resolution`. A run that
    diverged so far that its energy is no number has no drift.
    """
    if is_celestial(scene):
        if not celestial.is_newtonian(scene):
            others = ", ".join(load.type for load in scene.loads if load.type not in ("newton", "epoch"))
            reason = f"the energy balance supports Newton's attraction alone, and {others} act here, too"
            return EnergyBalance(np.zeros(len(trajectory.times)), None, None, 0.0, reason)
        energy = celestial.energy(scene, trajectory).astype(float)
        return EnergyBalance(energy, np.zeros_like(energy), celestial.drift(scene, trajectory), 0.0)
    if any(isinstance(load, Newton) for load in scene.loads):
        return _attracted(scene, trajectory)
    energy = kinetic_energy(scene, trajectory) + potential_energy(scene, trajectory)
    is_known = bool(np.isfinite(energy).all())
    reason = _undefined(scene, trajectory) if is_known else _not_finite(trajectory)
    if reason or not is_known:
        return EnergyBalance(energy, None, None, 0.0, reason)
    power = powers(Motion(scene, trajectory), is_conservative)
    if power is None:
        return EnergyBalance(energy, np.zeros_like(energy), energy - energy[0], 0.0)
    if len(energy) < 9:
        return EnergyBalance(energy, None, None, 0.0, f"{len(energy)} samples are too few to integrate the work; use 9")
    # at order 6 half of the spacing divides errors by 64: a quarter of the difference is safe; at a jump by 2 at best
    integral, share = (_splines, 0.25) if _is_smooth(scene, trajectory) else (_trapezoids, 2.0)
    times, work = trajectory.times, integral(trajectory.times, power)
    resolution = share * float(np.max(np.abs(integral(times[::2], power[::2]) - work[::2])))
    return EnergyBalance(energy, work, energy - energy[0] - work, resolution)


def _attracted(scene: Scene, trajectory: Trajectory) -> EnergyBalance:
    """Free rigid bodies under Newton's attraction: orbits and spins keep their energies apart."""
    others = [load.name for load in scene.loads if load.type not in ("newton", "epoch", "gravity_gradient")]
    if scene.joints or others:
        reason = "the energy balance supports attracting bodies without joints or other loads alone"
        return EnergyBalance(np.zeros(len(trajectory.times)), None, None, 0.0, reason)
    spin, motion = _rotation(scene, trajectory), Motion(scene, trajectory)
    for load in scene.loads:
        if isinstance(load, GravityGradient):
            spin = spin + _gradient(motion, load)
    energy = celestial.energy(scene, trajectory).astype(float) + spin
    return EnergyBalance(energy, np.zeros_like(energy), celestial.drift(scene, trajectory) + spin - spin[0], 0.0)


def _not_finite(trajectory: Trajectory) -> str:
    """Return why the energy of a run is no number; empty where its samples are incomplete."""
    samples = trajectory.position, trajectory.orientation, trajectory.velocity, trajectory.angular_velocity
    return "" if any(np.isnan(part).any() for part in samples) else "the run has diverged: its energy overflows"


def _undefined(scene: Scene, trajectory: Trajectory) -> str:
    drives = [j.name for j in scene.joints if isinstance(j, Drive)]
    missing = [name for name in drives if name not in trajectory.reactions]
    if missing:
        return f"energy is not conserved: {', '.join(missing)} does work, and the engine reports no reaction there"
    driving = [j.name for j in scene.joints if isinstance(j, UserConstraint) and j.depends_on_time]
    if driving:
        return f"{', '.join(driving)} may move in time and do work, which does not follow from its reaction"
    if any(getattr(load, "half", ()) for load in scene.loads):
        return "the work at granules with `half` does not follow from poses here"
    silent = [c.name for c in scene.contacts if c.name not in trajectory.contacts]
    if silent:
        return f"contact {', '.join(silent[:4])} does work, and the engine reports no force there"
    struck = _struck(scene, trajectory)
    if struck:
        return f"the impulse of contact {', '.join(struck[:4])} takes energy at once, between samples"
    if scene.breakpoints() and any(0.0 < t < trajectory.times[-1] for t in scene.breakpoints()):
        return "a load or drive jumps within the run; the work across the jump is not resolved by samples"
    return ""


def _struck(scene: Scene, trajectory: Trajectory) -> list[str]:
    """Return the contacts whose impulses took energy within the run."""
    events = trajectory.event_times
    lossy = [c.law.IMPULSIVE and c.law.numbers().restitution < 1.0 for c in scene.contacts]
    if events is None or not any(lossy):
        return []
    met = {int(k) for k in events[:, 1]}
    return [c.name for k, c in enumerate(scene.contacts) if lossy[k] and k in met]


def _is_smooth(scene: Scene, trajectory: Trajectory) -> bool:
    """Return whether no contact event lies inside the run; False if the engine locates none."""
    events = trajectory.event_times
    if not touching(scene):
        return True
    if events is None or len(touching(scene)) > len(scene.contacts):
        return False
    when = events[events[:, 1] < len(scene.contacts), 0]  # declared events and slack springs do not make power jump
    return not np.any((when > 0.0) & (when < trajectory.times[-1]))


def _trapezoids(times: np.ndarray, power: np.ndarray) -> np.ndarray:
    return scipy.integrate.cumulative_trapezoid(power, times, initial=0.0)


def _splines(times: np.ndarray, power: np.ndarray) -> np.ndarray:
    degree = min(5, (len(times) - 1) // 2 * 2 - 1)
    primitive = scipy.interpolate.make_interp_spline(times, power, k=degree).antiderivative()
    return primitive(times) - primitive(times[0])


def _spring(motion: Motion, load: parts.SpringDamper) -> np.ndarray:
    _, stretch, _ = length_of(motion, load)
    if load.tension_only:
        stretch = np.maximum(stretch, 0.0)
    _, elastic = pull_of(load, stretch, np.zeros_like(stretch))
    return elastic * stretch - 0.5 * elastic**2 / load.stiffness if load.stiffness else elastic


def _force(motion: Motion, load: parts.Force) -> np.ndarray:
    place, _ = motion.point(load.body, load.point)
    return -_constant(load.factor) * ((place - np.asarray(load.point)) @ np.asarray(load.vector))


def _gradient(motion: Motion, load: GravityGradient) -> np.ndarray:
    """-gm / (2 d^3) (tr J - 3 d.J d / d^2): MacCullagh's potential beyond the point mass's."""
    k, planet = (motion.scene.body_index(name) for name in (load.body, load.planet))
    body: Any = motion.scene.bodies[k]
    d = motion.trajectory.position[:, k] - motion.trajectory.position[:, planet]
    axes = rotation_matrices(motion.trajectory.orientation[:, k])
    local = np.einsum("tij,ti->tj", axes, d)
    square = np.sum(d**2, axis=1)
    moment = np.sum(local * (local @ body.inertia_matrix), axis=1) / square
    return -0.5 * load.gm / square**1.5 * (np.trace(body.inertia_matrix) - 3.0 * moment)


def _constant(factor: Signal) -> float:
    return factor.segments()[0].coefficients[0]


POTENTIALS: dict[type, Callable[[Motion, Any], np.ndarray]] = {
    GravityGradient: _gradient,
    parts.SpringDamper: _spring,
    parts.TorsionSpring: lambda motion, load: 0.5 * load.stiffness * twist_of(motion, load)[0] ** 2,
    parts.Bushing: lambda motion, load: 0.5 * bushing_strain(motion, load)[0] ** 2 @ np.asarray(load.stiffness),
    parts.PointBushing: lambda motion, load: 0.5 * load.stiffness * np.sum(gap_of(motion, load)[0] ** 2, axis=1),
    parts.Force: _force,
    parts.Torque: lambda motion, load: -_constant(load.factor) * load.torque * motion.angle(load.body),
}
