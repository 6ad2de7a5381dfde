"""Contact at the edge: stiff floors, thin plates at speed, deep starts, heavy on light, endless bouncing, grip.

Blocks that Coulomb's law holds creep, slide or stay by the reference solver and by engines' own contact models.
"""

import math

import numpy as np

from cross_checks.contact import own_engine
from cross_checks.contact.by_figure import pressed, slope
from cross_checks.extremes import STEP, Case, Measured, by_positions, grid, in_plane
from cross_checks.extremes.parts import made
from mbs_ref import Scene, Trajectory
from mbs_ref.scenes.blocks import incline as incline

RADIUS = 0.1  # m
FRICTION = 0.3


def _deep(depth: float) -> Case:
    """The floor throws the ball out: y = -depth cos(w t) up to a quarter period, then free."""
    stiffness, radius, ball = 1e4, 0.05, 1.0  # N/m, m, kg
    rate = math.sqrt(stiffness / ball)

    def exact(times: np.ndarray) -> np.ndarray:
        phase = rate * times
        y = np.where(phase < 0.5 * math.pi, -np.cos(np.minimum(phase, 0.5 * math.pi)), phase - 0.5 * math.pi)
        return in_plane(0.0, radius + depth * y)

    size = depth * rate * 0.1  # m, how far it flies
    return Case(made("deep_start", depth=depth), grid(0.1), by_positions(exact, size))


def _resting(scene: Scene, t_end: float, size: float = 1.0) -> Case:
    """Return a case in which every body stays until t_end (s); `size` in m."""
    start = np.array([body.position for body in scene.bodies])
    return Case(scene, grid(t_end), by_positions(lambda times: np.tile(start, (len(times), 1, 1)), size))


END = 1.0  # s
SHARE = 0.29  # of the cone, where the axis is another


def creep(scene: Scene, path: Trajectory) -> Measured:
    """Return the largest mean speed over the last half, over the speed that weight alone would give within the run."""
    middle = len(path.times) // 2
    way = np.abs(path.position[-1] - path.position[middle]) @ np.array((1.0, 0.0, 0.0))  # weight pulls along x
    free = scene.gravity[0] * path.times[-1]
    return Measured(float(way.max()) / float(path.times[-1] - path.times[middle]) / free)


def _held(scene: Scene, step: float = STEP, **more) -> Case:
    return Case(scene, grid(END, step, 5), creep, step=step, **more)


HELD = {
    "hold-slope": lambda share: _held(slope(share, 0.0)),
    "hold-wall": lambda share: _held(pressed(share)),
    "hold-grip": lambda share: _held(pressed(share, 2)),
    "hold-stack": lambda ratio: _held(slope(SHARE, ratio)),
    "hold-heavy-jaw": lambda ratio: _held(pressed(SHARE, 2, ratio)),
    "hold-step": lambda step: _held(slope(SHARE, 0.0), step, rtol=None),
}
ENGINES = dict.fromkeys(HELD, own_engine)  # each under its own contact model
CASES = {
    "deep-start": _deep,
    # a light ball between the floor and a heavy one, in equilibrium
    "heavy-on-light": lambda ratio: _resting(made("heavy_on_light", ratio=ratio), 0.5, RADIUS),
    # tan(angle) = mu (1 - margin): it stays, but for the give of the sticking spring
    "stick-slip-edge": lambda gap: _resting(incline(angle=math.atan(FRICTION * (1.0 - gap)), friction=FRICTION), 1.0),
} | HELD
