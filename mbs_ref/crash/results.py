"""Results of an android's crash: forces, excursions, accelerations, injury measures, works."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_simpson

from mbs_ref.cores.planar import PlanarSystem
from mbs_ref.cores.system import Poses
from mbs_ref.crash import injury
from mbs_ref.crash.stops import STOP, stop_load, tension
from mbs_ref.observables.attachment import Motion, twist_of
from mbs_ref.observables.energy import kinetic_energy, potential_energy
from mbs_ref.observables.powers import LOADS, contact_power
from mbs_ref.scene import Force, PointBushing, Revolute, Scene, SpringDamper, TorsionSpring
from mbs_ref.scene.signals import values
from mbs_ref.trajectory import Trajectory

CRASH, BELT = "crash.", "belt."
FIRST_REBOUND = 0.12  # s, peaks of the head are quoted before the neck reaches its end
AGE = 45.0  # years, assumed for TTI, which adds 1.4 a year; the measure applies to side impacts
STERNUM, SPINE = "costal_4_5", "T7"  # the tip of rib 4 lies in front of T7: between them the chest's depth is read
ONE_NEWTON_METRE = 1.0  # N m; a smaller torque has no sign worth the name
CERVICAL = ("C1", "C2", "C3", "C4", "C5", "C6")


@dataclass(frozen=True)
class BodyForces:
    """Per body along a motion: N, N, N m, in the scene's body order."""

    external: np.ndarray  # (n_t, n_bodies, 3) Q_e: gravity, loads, contacts
    constraint: np.ndarray  # (n_t, n_bodies, 3) Q_c = -C_q^T lambda
    acceleration: np.ndarray  # (n_t, n_bodies, 3) m/s^2, m/s^2, rad/s^2


def body_forces(scene: Scene, trajectory: Trajectory) -> BodyForces:
    """Evaluate Q_e, and Q_c = M qdd - Q_e, at every sample of any engine's planar motion.

    Contact forces follow from the state alone: their laws must need no located events.
    """
    system = PlanarSystem(scene)
    states = system.states_of(Poses.of(trajectory))
    system.start_contacts(0.0, states[0], located=False)
    external, acceleration = np.zeros((2, len(states), len(scene.bodies), 3))
    for k, (t, y) in enumerate(zip(trajectory.times, states, strict=True)):
        system.set_mode_time(t)
        external[k], acceleration[k] = system.applied_forces(t, y), system.accelerations(t, y)
    constraint = system.mass_matrix().reshape(-1, 3) * acceleration - external
    return BodyForces(external, constraint, acceleration)


@dataclass(frozen=True)
class CrashResults:
    """Histories over (n_t,) samples, and the measures computed from them."""

    forces: BodyForces
    seat_force: np.ndarray  # (n_t,) N, sum of the seat's contact forces
    belt_force: np.ndarray  # (n_t,) N, sum of the belts' tensions
    head_g: np.ndarray  # (n_t,) g, of the head against inertial space
    thorax_g: np.ndarray  # (n_t,) g
    head_excursion: np.ndarray  # (n_t, 2) m, from the pose at t = 0, in the vehicle
    hip_excursion: np.ndarray  # (n_t, 2) m
    neck_axial: np.ndarray  # (n_t,) N at the occipital joint, tension positive
    neck_moment: np.ndarray  # (n_t,) N m there, of the neck on the head, flexion positive
    nij: np.ndarray  # (n_t,)
    cervical_torques: dict[str, np.ndarray]  # vertebra -> (n_t,) N m on it of the joint beneath
    chest_deflection: np.ndarray | None  # (n_t,) m; None where the thorax is one rigid body
    works: dict[str, np.ndarray]  # (n_t,) J done since t = 0 by pulse, belts' and joints' dampers, contacts
    energy: np.ndarray  # (n_t,) J
    measures: dict[str, float]


def crash_results(scene: Scene, trajectory: Trajectory) -> CrashResults:
    """Evaluate an android's crash with its seat fixed; Simpson's rule integrates works over the samples."""
    motion, forces = Motion(scene, trajectory), body_forces(scene, trajectory)
    head, thorax = _felt(scene, trajectory, forces, "head"), _felt(scene, trajectory, forces, _or_thorax(scene, "T4"))
    works = {name: cumulative_simpson(p, x=trajectory.times, initial=0.0) for name, p in _powers(motion).items()}
    axial, moment, chest = _neck_axial(motion), _neck_moment(motion), _chest(motion)
    nij = injury.nij(axial, moment)
    rib, t12 = (_felt(scene, trajectory, forces, _or_thorax(scene, part)) for part in ("rib4", "T12"))
    belts = [load for load in scene.loads if isinstance(load, SpringDamper) and load.name.startswith(BELT)]
    measures = _head_and_neck(trajectory.times, head, axial, nij) | _thorax_measures(motion, thorax, rib, t12, chest)
    return CrashResults(
        forces=forces,
        seat_force=np.sum([np.hypot(c[:, 1], c[:, 2]) for n, c in trajectory.contacts.items() if "seat" in n], axis=0),
        belt_force=np.sum([np.zeros(len(trajectory.times)), *(tension(motion, b) for b in belts)], axis=0),
        head_g=head,
        thorax_g=thorax,
        head_excursion=_excursion(scene, trajectory, "head"),
        hip_excursion=_excursion(scene, trajectory, "bottom"),
        neck_axial=axial,
        neck_moment=moment,
        nij=nij,
        cervical_torques=_cervical_torques(motion),
        chest_deflection=None if chest is None else chest[0] - chest,
        works=works,
        energy=kinetic_energy(scene, trajectory) + potential_energy(scene, trajectory),
        measures=measures,
    )


def _or_thorax(scene: Scene, part: str) -> str:
    """The simplified android's thorax is one body."""
    return "thorax" if "thorax" in scene.body_names else part


def _excursion(scene: Scene, trajectory: Trajectory, body: str) -> np.ndarray:
    place = trajectory.position[:, scene.body_index(body)]
    return place - place[0]


def _felt(scene: Scene, trajectory: Trajectory, forces: BodyForces, body: str) -> np.ndarray:
    """Return |a| in g against inertial space: the frame of a fixed seat has the pulse's acceleration itself."""
    k = scene.body_index(body)
    acceleration = forces.acceleration[:, k, :2].copy()
    for load in scene.loads:
        if isinstance(load, Force) and load.name == CRASH + body:
            pulse = values(load.factor, trajectory.times)[:, None] * np.array(load.vector)
            acceleration -= pulse / scene.bodies[k].mass
    return np.hypot(*acceleration.T) / injury.STANDARD_GRAVITY


def _neck_axial(motion: Motion) -> np.ndarray:
    """Return the pull of the neck on the head, joint and stops, along the head's own axis; positive in tension."""
    joint = next(j for j in motion.scene.joints if isinstance(j, Revolute) and "head" in j.name.split("-"))
    sign = 1.0 if joint.body_b == "head" else -1.0
    stops, _ = stop_load(motion, joint.point, "head", joint.body_a if sign > 0.0 else joint.body_b)
    down, _ = motion.direction("head", (0.0, -1.0))
    return np.sum((sign * motion.trajectory.reactions[joint.name][:, :2] + stops) * down, axis=1)


def _neck_moment(motion: Motion) -> np.ndarray:
    """Return the restoring torque on the head; it is positive where the head has turned forward (SAE J1733)."""
    occipital = next(s for s in _torsions(motion.scene) if "head" in (s.body_a, s.body_b))
    return _restoring(motion, occipital, "head")


def _torsions(scene: Scene) -> list[TorsionSpring]:
    return [load for load in scene.loads if isinstance(load, TorsionSpring)]


def _restoring(motion: Motion, spring: TorsionSpring, body: str) -> np.ndarray:
    """Return the torque (n_t,), N m, of a torsion spring and of the joint's stops on its upper body."""
    twist, rate = twist_of(motion, spring)
    torque = spring.stiffness * twist + spring.damping * rate
    own = torque if body == spring.body_a else -torque
    pair = {spring.body_a, spring.body_b}
    joint = next((j for j in motion.scene.joints if isinstance(j, Revolute) and {j.body_a, j.body_b} == pair), None)
    return own if joint is None else own + stop_load(motion, joint.point, body, (pair - {body}).pop())[1]


def _cervical_torques(motion: Motion) -> dict[str, np.ndarray]:
    """Return the torque that the joint beneath puts on each cervical vertebra."""
    beneath = {s.body_a: s for s in _torsions(motion.scene) if s.body_a in CERVICAL}
    return {name: _restoring(motion, beneath[name], name) for name in CERVICAL if name in beneath}


def sign_changes(times: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Return the times (s) at which a torque (n_t,), N m, has another sign than before, where it has any."""
    loaded = np.abs(torque) > ONE_NEWTON_METRE
    return times[loaded][1:][np.diff(np.sign(torque[loaded])) != 0.0]


def _chest(motion: Motion) -> np.ndarray | None:
    """Return the distance (n_t,), m, between the tip of a rib and the vertebra behind it."""
    tip = next((x for x in motion.scene.loads if isinstance(x, PointBushing) and x.name == STERNUM), None)
    if tip is None:
        return None
    behind = motion.trajectory.position[:, motion.scene.body_index(SPINE)]
    return np.linalg.norm(motion.point(tip.body_b, tip.point)[0] - behind, axis=1)


def _powers(motion: Motion) -> dict[str, np.ndarray]:
    """Return the power (n_t,), W, of each kind of part that is not conservative."""
    names = ("pulse", "belts", "joint dampers", "joint stops", "tissue", "contacts")
    power = {name: np.zeros(len(motion.times)) for name in names}
    kinds = {Force: "pulse", SpringDamper: "belts", TorsionSpring: "joint dampers", PointBushing: "tissue"}
    for load in motion.scene.loads:
        kind = "joint stops" if load.name.startswith(STOP) else kinds[type(load)]
        power[kind] += LOADS[type(load)](motion, load)
    for contact in motion.scene.contacts:
        power["contacts"] += contact_power(motion, contact)
    return power


def _head_and_neck(times: np.ndarray, head: np.ndarray, axial: np.ndarray, nij: np.ndarray) -> dict[str, float]:
    early = times < FIRST_REBOUND
    return {
        "HIC15": injury.hic(times, head, 0.015)[0],
        "HIC36": injury.hic(times, head, 0.036)[0],
        "GSI": injury.gsi(times, head),
        "head 3 ms clip, g": injury.clip(times, head),
        "head peak before 120 ms, g": float(np.max(head[early])),
        "neck tension, N": float(max(np.max(axial), 0.0)),
        "neck compression, N": float(max(-np.min(axial), 0.0)),
        "Nij": float(np.max(nij)),
    }


def _thorax_measures(
    motion: Motion, thorax: np.ndarray, rib: np.ndarray, t12: np.ndarray, chest: np.ndarray | None
) -> dict[str, float]:
    """Return the measures of the thorax; the viscous criterion needs a deformable chest."""
    mass = sum(b.mass for b in motion.scene.bodies if not b.name.startswith("seat"))
    figures = {
        "thorax 3 ms clip, g": injury.clip(motion.times, thorax),
        "TTI(d), g": injury.TTI_LOAD * float(rib.max() + t12.max()),  # of 49 CFR 571.214, without age and mass
        f"TTI at {AGE:g} years, g": injury.thoracic_trauma_index(AGE, float(rib.max()), float(t12.max()), mass),
    }
    if chest is not None:
        figures["chest deflection, m"] = float(np.max(chest[0] - chest))
        figures["VC, m/s"] = injury.viscous_criterion(motion.times, chest[0] - chest, float(chest[0]))
    return figures
