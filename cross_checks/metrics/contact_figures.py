"""What contact did, from world poses: restitution, depth, duration, impulse, stop distance, creep, static sink.

Forces jump at touch-down and lift-off, so no norm of them is taken. Figures that a run does not show (it never
touches, or never leaves, or never rests) are left out.
"""

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import gap_of, shapes_known
from mbs_ref.scene import GROUND, Scene
from mbs_ref.trajectory import Trajectory

STILL = 1e-4  # m/s: slower is at rest, regularised friction creeps
STEADY = 0.1  # relative change of a mean speed that counts as steady
MANY = 12  # contacts beyond which nobody reads a figure of each
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
    gap, rate, slip = gap_of(motion, contact)
    touching = gap < 0.0
    figures = {"penetration, m": _deepest(motion.times, gap, rate)} if touching.any() else {}
    figures |= _bounce(motion, contact, gap, rate)
    if touching[-1] and contact.friction is not None and abs(slip[0]) < STILL:
        figures |= _creep(motion, contact)
    if touching[-1] and abs(rate[-1]) < STILL and abs(slip[-1]) < STILL:
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
    """Return restitution, duration and impulse of a single bounce with two samples in free flight either side."""
    first, last = _flights(gap, rate)
    if first is None or last is None:
        return {}
    approach, start = _at_surface(motion.times, gap, rate, first)
    leaving, end = _at_surface(motion.times, gap, rate, last)
    if not approach < 0.0 < leaving or not end >= start:
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


def _at_surface(times: np.ndarray, gap: np.ndarray, rate: np.ndarray, pair: tuple[int, int]) -> tuple[float, float]:
    """Continue a flight of constant acceleration from two samples to gap = 0; return its rate and the time there."""
    i, j = pair
    near = j if abs(gap[j]) < abs(gap[i]) else i
    a = (rate[j] - rate[i]) / (times[j] - times[i])
    square = rate[near] ** 2 - 2.0 * a * gap[near]
    if not square >= 0.0:
        return float("nan"), float("nan")
    speed = np.copysign(np.sqrt(square), rate[near])
    # t = -2 gap / (rate + speed) has no cancellation
    return float(speed), float(times[near] - 2.0 * gap[near] / (rate[near] + speed))


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
