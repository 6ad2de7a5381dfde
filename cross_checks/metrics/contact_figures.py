"""What contact did, from world poses: restitution, depth, duration, impulse, stop distance, creep, static sink.

Forces jump at touch-down and lift-off, so no norm of them is taken. Figures that a run does not show (it never
touches, or never leaves, or never rests) are left out.
"""

import numpy as np
import scipy

from mbs_ref import Trajectory
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import gap_of, shapes_known
from mbs_ref.scene import GROUND, Scene
from mbs_ref.scene.contact import RoundPair

STILL = 1e-4  # m/s: slower is at rest, regularised friction creeps
STEADY = 0.1  # relative change of a mean speed that counts as steady
MANY = 12  # contacts beyond which nobody reads a figure of each
PLACES = 33  # along the continuation of a flight, between which its gap changes its sign once
ROUNDOFF_GAP = 1e-9  # m: a rigid contact is closed where its gap is less
LEAST_PATH = 1e-9  # m: a shorter path is no stop distance


def contact_figures(scene: Scene, path: Trajectory) -> dict[str, float]:
    """Return the figures by "contact: figure, unit"; empty for scenes with very many contacts."""
    if not scene.contacts or len(scene.contacts) > MANY or len(path.times) < 4:
        return {}
    motion = Motion(scene, path)
    listed: dict[str, float] = {}
    for contact in scene.contacts:
        if shapes_known(contact):
            figures = _of_contact(motion, contact)
            listed |= {f"{contact.name}: {label}": value for label, value in figures.items() if np.isfinite(value)}
    return listed


def _of_contact(motion: Motion, contact) -> dict[str, float]:
    (gap, rate, slip), path = gap_of(motion, contact), motion.trajectory
    events = path.event_times  # None where the engine locates no events
    if gap[0] > 0.0 and events is not None and contact.name not in [path.event_names[int(k)] for k in events[:, 1]]:
        return {}
    rests = gap[-1] < ROUNDOFF_GAP
    figures = {"penetration, m": _deepest(motion.times, gap, rate)} if (gap < 0.0).any() else {}
    figures |= _bounce(motion, contact, gap, rate)
    if rests and contact.friction is not None and abs(slip[0]) < STILL:
        figures |= _creep(motion, contact)
    if rests and abs(rate[-1]) < STILL and abs(slip[-1]) < STILL:
        figures["static sink, m"] = -float(gap[-1])
        figures |= _stop(motion, contact, slip)
    return figures


def _deepest(times: np.ndarray, gap: np.ndarray, rate: np.ndarray) -> float:
    """Return the largest depth (m) of the cubics through gaps and rates, over the samples inside."""
    h = np.diff(times)
    s = np.linspace(0.0, 1.0, 33)[:, None]
    inside = (gap[:-1] < 0.0) & (gap[1:] < 0.0)
    lowest = float(np.min(gap))
    if not inside.any():
        return -lowest
    g0, g1, r0, r1 = gap[:-1], gap[1:], h * rate[:-1], h * rate[1:]
    cubic = (2 * s**3 - 3 * s**2 + 1) * g0 + (s**3 - 2 * s**2 + s) * r0
    cubic += (3 * s**2 - 2 * s**3) * g1 + (s**3 - s**2) * r1
    return -min(lowest, float(np.min(cubic[:, inside])))


def _bounce(motion: Motion, contact, gap: np.ndarray, rate: np.ndarray) -> dict[str, float]:
    """Return restitution, duration and impulse of a single bounce with two samples in free flight either side.

    The impulse acts along one normal: none is stated where the bodies part on another side than they met.
    """
    first, last = _flights(gap, rate)
    if first is None or last is None:
        return {}
    met, parted = _at_surface(motion, contact, first, last[0]), _at_surface(motion, contact, last, first[1])
    if met is None or parted is None:
        return {}
    (approach, start, side), (leaving, end, other) = met, parted
    if not (approach < 0.0 < leaving and end >= start and side @ other > 0.0):
        return {}
    figures = {"restitution": -leaving / approach, "duration, s": end - start}
    mass = _free_mass(motion, contact)
    return figures if mass is None else figures | {"impulse, N s": mass * (leaving - approach)}


def _flights(gap: np.ndarray, rate: np.ndarray) -> tuple[tuple[int, int] | None, tuple[int, int] | None]:
    """Return the last two samples before the only stay inside and the first two after it, where there are."""
    turns = np.flatnonzero((rate[:-1] < 0.0) & (rate[1:] > 0.0))
    outside = gap > 0.0
    if len(turns) != 1:
        return None, None
    before = np.flatnonzero(outside[: turns[0] + 1] & (rate[: turns[0] + 1] < 0.0))
    after = np.flatnonzero(outside[turns[0] + 1 :] & (rate[turns[0] + 1 :] > 0.0)) + turns[0] + 1
    if len(before) < 2 or len(after) < 2:
        return None, None
    return (int(before[-2]), int(before[-1])), (int(after[0]), int(after[1]))


def _at_surface(motion: Motion, contact, pair: tuple[int, int], limit: int) -> tuple[float, float, np.ndarray] | None:
    """Continue a flight from two samples with constant accelerations to gap = 0 before sample `limit`.

    Returns the gap's rate, the time, and from where body a comes, seen from a round body b; None without a root.
    """
    near = pair[1] if limit > pair[1] else pair[0]
    start, end = motion.times[[near, limit]]

    def gap(time: float) -> float:
        return float(gap_of(_continued(motion, pair, near, np.array([time])), contact)[0][0])

    grid = np.linspace(start, end, PLACES)
    inside = np.flatnonzero(gap_of(_continued(motion, pair, near, grid), contact)[0] <= 0.0)
    if not len(inside) or inside[0] == 0:
        return None
    time = float(scipy.optimize.brentq(gap, *grid[inside[0] - 1 : inside[0] + 1], xtol=1e-300, rtol=1e-15))  # type: ignore[arg-type]
    there, side = _continued(motion, pair, near, np.array([time])), np.ones(1)
    if isinstance(contact, RoundPair):
        side = there.point(contact.body_a, contact.center_a)[0][0] - there.point(contact.body_b, contact.center_b)[0][0]
    return float(gap_of(there, contact)[1][0]), time, side


def _continued(motion: Motion, pair: tuple[int, int], near: int, times: np.ndarray) -> Motion:
    """Return the motion at other times (s), as if accelerations were those between two samples."""
    path, (i, j) = motion.trajectory, pair
    after = (times - path.times[near])[:, None, None]
    span = path.times[j] - path.times[i]
    change = [(rate[j] - rate[i]) / span for rate in (path.velocity, path.angular_velocity)]
    turn = after.reshape(-1, *(1,) * change[1].ndim)
    moved = path.position[near] + after * (path.velocity[near] + 0.5 * after * change[0])
    turned = turn * (path.angular_velocity[near] + 0.5 * turn * change[1])
    if motion.scene.planar:
        orientation = path.orientation[near] + turned
    else:
        own = scipy.spatial.transform.Rotation.from_quat(path.orientation[near], scalar_first=True)
        orientation = np.array(
            [(scipy.spatial.transform.Rotation.from_rotvec(each) * own).as_quat(scalar_first=True) for each in turned]
        )
    rates = path.velocity[near] + after * change[0], path.angular_velocity[near] + turn * change[1]
    return Motion(motion.scene, Trajectory(times, moved, orientation, *rates))


def _free_mass(motion: Motion, contact) -> float | None:
    """Return the reduced mass (kg) of two bodies without joints or loads, hit through their centres; else None."""
    scene = motion.scene
    if scene.joints or scene.loads or any(scene.gravity) or len(scene.contacts) > 1 or contact.friction is not None:
        return None
    bodies = [scene.bodies[scene.body_index(n)] for n in (contact.body_a, contact.body_b) if n != GROUND]
    marks = [getattr(contact, "center", getattr(contact, "center_a", None)), getattr(contact, "center_b", None)]
    if any(mark is not None and mark != b.position for mark, b in zip(marks, bodies, strict=False)):
        return None
    if len(bodies) == 2 and contact.type != "circle_on_circle":
        return None
    return 1.0 / sum(1.0 / body.mass for body in bodies)


def _creep(motion: Motion, contact) -> dict[str, float]:
    """Return the mean speed of body a over the last half, where its quarters have the same or none."""
    n, k = len(motion.times), motion.scene.body_index(contact.body_a)
    samples = [n // 2, 3 * n // 4, n - 1]
    ways = np.diff(motion.trajectory.position[samples, k], axis=0)
    spans = np.diff(motion.times[samples])
    first, last = np.linalg.norm(ways, axis=1) / spans
    if abs(last - first) > STILL + STEADY * last:
        return {}
    return {"creep, m/s": float(np.linalg.norm(ways.sum(axis=0)) / spans.sum())}


def _stop(motion: Motion, contact, slip: np.ndarray) -> dict[str, float]:
    """Return how far body a slid before it came to rest, where it was under way at the start; what rolls does not."""
    k = motion.scene.body_index(contact.body_a)
    if contact.friction is None or abs(slip[0]) < STILL or np.linalg.norm(motion.trajectory.velocity[-1, k]) > STILL:
        return {}
    way = float(np.linalg.norm(motion.trajectory.position[-1, k] - motion.trajectory.position[0, k]))
    return {"stop distance, m": way} if way > LEAST_PATH else {}
