"""Identify the joints or springs that stopped a run, and detect a passage close to a singular pose.

The output samples are examined after the run. A passage between two samples is detected only as far as they show it.
"""

import numpy as np

from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import Poses, System
from mbs_ref.observables.attachment import Motion, bushing_strain, twist_of
from mbs_ref.scene import Bushing, TorsionSpring, UserForce
from mbs_ref.trajectory import Status, Trajectory

NEAR_SINGULAR = 1e-3  # smallest singular value of the scaled C_q below which joints are always named
MAX_ROWS = 600  # a dense SVD of more takes seconds
SHARE = 0.5  # of the largest component of the weakest direction: joints with less are not named
MOST_NAMED = 4
NEARLY_TURNED = 2.5  # rad; springs in space stop the run at 3 rad
CLOSED = frozenset({Status.SINGULAR, Status.PROJECTION})  # a loop that cannot be closed
NEAR = 0.05  # of the smallest singular value at the start: roundoff in reactions is 20 times what it was there
SUSPECT = 0.05  # relative closure pivot below which singular values are computed; pivots scale as their squares
MAX_SAMPLES = 200  # evenly spaced samples whose pivots are computed, if the reactions' evaluation has left none
LOOKS = 20_000  # random times, one in each of so many equal intervals, at which users' forces are evaluated
UNSEEN = 0.1  # of a force's largest value: by how much it must differ from where steps have evaluated it
MAX_CLOSE = 5  # samples with the smallest pivots, whose singular values are computed


def culprit(system: System, t: float, y: np.ndarray) -> str:
    """Return a clause on the body with the largest acceleration and the joint with the largest violation at (t, y)."""
    scene, half = system.scene, system.n_positions
    with np.errstate(all="ignore"):
        rate = np.abs(system.derivative(t, y)[half:])
        gaps = {name: float(np.max(np.abs(pair[0]), initial=0.0)) for name, pair in system.residuals(t, y).items()}
    fastest = int(np.argmax(np.where(np.isnan(rate), np.inf, rate)))
    body = scene.bodies[min(fastest // max(1, len(rate) // len(scene.bodies)), len(scene.bodies) - 1)].name
    words = f"; body {body!r} has the largest acceleration there ({rate[fastest]:.3g} m/s^2 or rad/s^2)"
    if gaps:
        joint = max(gaps, key=lambda name: np.inf if np.isnan(gaps[name]) else gaps[name])
        words += f", and joint {joint!r} has the largest violation ({gaps[joint]:.3g} m or rad)"
    return words


def deeper_cause(system: System, status: Status, t: float, y: np.ndarray) -> str:
    """Return a clause on joints near rank loss, or on springs near the limit of their angle; or nothing."""
    if not np.isfinite(y).all():
        return ""
    with np.errstate(all="ignore"):
        springs, joints = _turned_springs(system, t, y), _weak_joints(system, status, t, y)
    return joints + springs if status in CLOSED else springs or joints


def weakest_joints(system: System, scaled: np.ndarray, independent: int) -> tuple[float, list[str]]:
    """Return the smallest singular value of the scaled C_q without permanent redundancy, and the joints of its rows."""
    joints = system.row_joints()
    rows, values, _ = np.linalg.svd(scaled, full_matrices=False)
    part = np.abs(rows[:, independent - 1])
    named = [joints[k] for k in np.argsort(-part) if part[k] > SHARE * part.max()]
    return float(values[independent - 1]), list(dict.fromkeys(named))[:MOST_NAMED]


def independent_rows(system: System) -> int:
    """Return the number of independent joint rows at the start; 0 for more than MAX_ROWS."""
    rows, start = len(system.row_joints()), system.initial_state()
    if not 0 < rows <= MAX_ROWS:
        return 0
    if system.has_sure_rank(0.0, start):
        return rows
    return int(np.linalg.matrix_rank(system.scaled_jacobian(0.0, start), tol=1e-9))


def _weak_joints(system: System, status: Status, t: float, y: np.ndarray) -> str:
    if system.n_closure_rows == 0:
        return ""
    independent = independent_rows(system)
    if not independent:
        return ""
    smallest, names = weakest_joints(system, system.scaled_jacobian(t, y), independent)
    if smallest > NEAR_SINGULAR and status not in CLOSED:
        return ""
    return f"; joint {_listed(names)} is nearest to rank loss (smallest singular value of C_q {smallest:.2g})"


def _turned_springs(system: System, t: float, y: np.ndarray) -> str:
    loads = [x for x in system.scene.loads if isinstance(x, Bushing) or (isinstance(x, TorsionSpring) and x.axis)]
    if not loads:
        return ""
    motion = Motion(system.scene, Trajectory(np.array([t]), *system.poses(y[None])))
    turned = {load.name: _turn(motion, load) for load in loads}
    names = [name for name, angle in turned.items() if abs(angle) > NEARLY_TURNED]
    return f"; load {_listed(names)} has turned by {turned[names[0]]:.3g} rad and cannot count turns" if names else ""


def _turn(motion: Motion, load: TorsionSpring | Bushing) -> float:
    if isinstance(load, Bushing):
        return float(np.linalg.norm(bushing_strain(motion, load)[0][0, 3:]))
    return float(twist_of(motion, load)[0][0]) + (load.rest_angle or 0.0)


def _listed(names: list[str]) -> str:
    return ", ".join(repr(name) for name in names)


def singular_passage(
    system: System, times: np.ndarray, states: np.ndarray, pivots: np.ndarray | None = None
) -> tuple[str, ...]:
    """Return a note on the sample (n_t of them) where C_q is nearest to rank loss, or nothing.

    `pivots` (n_t,) are the closures' smallest ones; without them those of some samples are computed.
    """
    if system.n_closure_rows == 0 or not len(times):
        return ()
    examined = np.arange(len(times))
    if pivots is None:
        examined = np.unique(np.linspace(0, len(times) - 1, MAX_SAMPLES).round().astype(int))
        pivots = system.pivots(times[examined], states[examined])
    close = [examined[k] for k in np.argsort(pivots)[:MAX_CLOSE] if pivots[k] < SUSPECT]
    independent = independent_rows(system) if close else 0
    if not independent:
        return ()
    scaled = system.scaled_jacobians(times[[0, *close]].tolist(), states[[0, *close]])
    # by the eigenvalues of C_q C_q^T, which are as exact above 1e-7 and cheaper
    squares = np.linalg.eigvalsh(scaled @ scaled.swapaxes(1, 2))[:, -independent]
    start, *sizes = np.sqrt(np.fmax(squares, 0.0)).tolist()
    if min(sizes) > NEAR * start:
        return ()
    nearest = int(np.argmin(sizes))
    t, (smallest, joints) = times[close[nearest]], weakest_joints(system, scaled[1 + nearest], independent)
    return (
        f"the run passes close to a singular pose at t = {t:.6g} s: the smallest singular value of C_q is "
        f"{smallest:.2g} there and {start:.2g} at the start, from joint {_listed(joints)}; branches may meet there",
    )


def unseen_forces(system: System, sampled: np.ndarray, poses: Poses) -> tuple[str, ...]:
    """Return a note for each user's force with a pulse at one of many random times that no step resolves.

    `poses` are those at the times `sampled` (n_t,), s.
    """
    own, loads = system.redundant, [load for load in system.scene.loads if isinstance(load, UserForce)]
    if not loads or not isinstance(own, JointedSystem):
        return ()
    shape = (*poses.position.shape[:2], -1)
    q = np.concatenate((poses.position, poses.orientation.reshape(shape)), axis=2)
    v = np.concatenate((poses.velocity, poses.angular_velocity.reshape(shape)), axis=2)
    ends, steps = np.linspace(0.0, sampled[-1], LOOKS + 1), np.unique(own.user_times)
    times = np.random.default_rng(0).uniform(ends[:-1], ends[1:])
    nearest = np.searchsorted(sampled, times, side="right") - 1

    def force(load: UserForce, t: float, k: int) -> np.ndarray:
        return np.array(load.function(float(t), q[k].copy(), v[k].copy()), dtype=float)

    def note(load: UserForce) -> str:
        forces = np.array([force(load, *at) for at in zip(times, nearest, strict=True)])
        sizes = np.max(np.abs(forces), axis=(1, 2))
        least = UNSEEN * float(np.max(sizes))
        jumps = np.max(np.abs(np.diff(forces, axis=0)), axis=(1, 2)) > least
        for i in np.flatnonzero(np.append(jumps, False) | np.append(False, jumps)):
            place = int(np.searchsorted(steps, times[i]))
            around = steps[max(place - 1, 0) : place + 1]
            if all(np.max(np.abs(forces[i] - force(load, t, nearest[i]))) > least for t in around):
                return (
                    f"load {load.name!r} is {sizes[i]:.3g} N or N m at t = {times[i]:.6g} s, which no step resolves: "
                    f"steps evaluate it at {' and '.join(f'{t:.6g}' for t in around)} s; request outputs there"
                )
        return ""

    try:
        return tuple(filter(None, map(note, loads)))
    except Exception:  # what a function raises outside of steps is no failure of the run
        return ()
