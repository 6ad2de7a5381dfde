"""A converged truth: two formulations, two integrators, two precisions; the difference is the error bar."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cross_checks.truths.made_by.numerics.rates import along
from cross_checks.truths.made_by.numerics.solvers import TOLERANCES, extrapolate, lsoda, radau, runge_kutta
from cross_checks.truths.truth import ALIKE, EPS, Truth
from mbs_ref.observables.distance import Partial, unmasked_distances

NUDGE = 1e-8  # of the start, to measure how the motion magnifies an error
NUDGED_TOLERANCE = 1e-2 * NUDGE  # of the nudged run: one digit of the growth is enough
LARGEST_UNCERTAINTY = 1e-8  # m; a truth known less well ranks nobody, and is not worth its computation
LOOKS = 0.01  # s, longest step of both solvers where forces set in or end: a longer one may miss a short force
RK_TOLERANCE = 3e-14  # the tightest DOP853 takes in double precision
ARM = 1.0  # m, at which differences of orientation in space count; the scenes' bodies are no larger


@dataclass(frozen=True)
class Formulation:
    """Equations of motion in some coordinates y."""

    derivative: Callable  # (t, y) -> dy/dt in y's precision
    start: np.ndarray  # (n,) y at t = 0
    poses: Callable  # (t, y) -> position (n_bodies, dimension) m, angle (n_bodies,) rad or theta (n_bodies, 4)
    frozen: Callable | None = None  # (t, y, on) -> dy/dt where forces set in or end: in the branches `on`
    switches: Callable | None = None  # (t, y) -> (n_switches,): on where positive
    breakpoints: tuple[float, ...] = ()  # s, where the derivative is not smooth in time


def agree(
    first: Formulation, second: Formulation, times: np.ndarray, ways: tuple[str, str], *, extended: bool,
    is_stiff: bool = False, is_costly: bool = False,
) -> Truth:  # fmt: skip
    """Solve `first` by DOP853 and `second` by extrapolation, in extended precision if so requested; compare poses.

    `ways` names the equations and methods of the first and of the second; the truth is the second's motion.
    Where forces set in or end, DOP853 reduces its steps by its error control, and extrapolation locates the time.
    Stiff motions are solved by LSODA and by Radau IIA instead.
    The uncertainty is the difference, times ALIKE unless the second is the more precise one, plus the roundoff of
    double data magnified by the motion. Where the latter alone exceeds LARGEST_UNCERTAINTY, there is no second run.
    """
    looks = [] if second.switches is None else np.arange(LOOKS, times[-1], LOOKS)
    grid, rows = _grid(times, (*first.breakpoints, *second.breakpoints, *looks))
    kind = np.longdouble if extended else float
    tolerance = TOLERANCES[kind]
    solve = lsoda if is_stiff else runge_kutta
    states = solve(first.derivative, first.start, grid, RK_TOLERANCE)
    coarse, rates = _poses(first, grid, states), _rates(first, grid, states)
    sensitivity = _sensitivity(first, grid, coarse, solve)
    fine, best, difference = coarse, rates, float("nan")
    uncertainty, doubt = EPS * sensitivity, np.full(len(grid), np.inf)
    if not uncertainty > LARGEST_UNCERTAINTY:
        start = second.start.astype(kind)
        if is_stiff:
            solved = radau(second.derivative, start, grid, tolerance)
        elif second.frozen is None:
            solved = extrapolate(second.derivative, start, grid, tolerance)
        else:
            solved = extrapolate(second.frozen, start, grid, tolerance, second.switches)
        fine, best = _poses(second, grid, solved), _rates(second, grid, solved)
        difference, roundoff = _gap(fine, coarse), EPS * max(1.0, sensitivity)
        apart = unmasked_distances(Partial(None, None, *best[:2]), Partial(None, None, *rates[:2]), best[1].ndim == 3)
        factor = 1.0 if extended else ALIKE
        uncertainty = factor * difference + roundoff
        doubt = best[2] + factor * apart[..., 2:].max(axis=(1, 2)) + roundoff
    how = f"{ways[1]}; {ways[0]} differ by {difference:.1e} m; a start error grows {sensitivity:.1e}-fold"
    return Truth(
        fine[0][rows], fine[1][rows], uncertainty, "converged", how, difference, is_costly,
        best[0][rows], best[1][rows], doubt[rows],
    )  # fmt: skip


def _grid(times: np.ndarray, breakpoints: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the times to stop at, from 0 on, and the indices of `times` in them."""
    times = np.asarray(times, dtype=float)
    inner = [t for t in breakpoints if 0.0 < t < times[-1]]
    grid = np.unique(np.concatenate(([0.0], times, inner)))
    return grid, np.searchsorted(grid, times)


def _poses(formulation: Formulation, times: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    poses = [formulation.poses(t, y) for t, y in zip(times, states, strict=True)]
    return tuple(np.array(part, dtype=float) for part in zip(*poses, strict=True))  # type: ignore[return-value]


def _rates(
    formulation: Formulation, times: np.ndarray, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return velocities, angular velocities and how well they are known (n_t,) at every time."""
    rates = [along(formulation.derivative, formulation.poses, t, y) for t, y in zip(times, states, strict=True)]
    return tuple(np.array(part) for part in zip(*rates, strict=True))  # type: ignore[return-value]


def _gap(first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]) -> float:
    """Return the largest distance between centres, and in space between points ARM away from them."""
    sizes = unmasked_distances(Partial(*first), Partial(*second), first[1].ndim == 3)
    return float(np.max(sizes[..., :2] * ((1.0, ARM) if first[1].ndim == 3 else (1.0, 0.0))))


def _sensitivity(formulation: Formulation, times: np.ndarray, poses: tuple, solve: Callable) -> float:
    """Nudge the start at random and see how far the motion moves away."""
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=len(formulation.start))
    states = solve(formulation.derivative, formulation.start + NUDGE * signs, times, NUDGED_TOLERANCE)
    return _gap(_poses(formulation, times, states), poses) / NUDGE
