"""Solvers of the truths: extrapolation, with and without branches, collocation, and those of SciPy."""

from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np
import scipy

from cross_checks.truths.made_by.numerics.closed_forms import legendre
from cross_checks.truths.truth import EPS, NoConvergenceError, Pace

COLUMNS = 10  # order 20 at most
SAFE = 0.9  # of the step that the error allows
LEAST, MOST = 0.1, 4.0  # of a step's length, the next one's
SMALLEST_STEP = 1e-9  # s


def attempt(derivative: Callable, t, y: np.ndarray, h, tolerance: float) -> tuple[np.ndarray | None, float]:
    """Return the state after one step, None where its columns do not converge, and the next step's length over h.

    That length has the least work for its length among the columns seen and the one after them (ibid., II.9).
    """
    row: list[np.ndarray] = []
    slope = derivative(t, y)
    scale = max(1.0, float(np.max(np.abs(y))))
    before, pace, longer = np.inf, 0.0, LEAST  # pace: most length for an evaluation so far, with a step so much longer
    for j in range(COLUMNS):
        fresh = [_midpoint(derivative, t, y, slope, h, 2 * (j + 1))]
        for k in range(1, j + 1):
            ratio = (y.dtype.type(j + 1) / (j + 1 - k)) ** 2
            fresh.append(fresh[k - 1] + (fresh[k - 1] - row[k - 1]) / (ratio - 1))
        if not np.all(np.isfinite(fresh[-1])):
            return None, LEAST
        if j:
            error = float(np.max(np.abs(fresh[-1] - row[-1]))) / (tolerance * scale)
            allowed, work = SAFE / max(error, EPS) ** (1 / (2 * j + 1)), (j + 1) * (j + 2)
            is_better = allowed / work > pace
            if is_better:
                pace, longer = allowed / work, allowed
            if error <= 1.0:
                if is_better and j + 1 < COLUMNS:
                    longer *= (j + 3) / (j + 1)  # a further column takes so much more work
                return fresh[-1], min(max(longer, LEAST), MOST)
            if error * (error / before) ** (COLUMNS - 1 - j) > 1.0:
                break  # at this rate the columns left do not converge
            before = error
        row = fresh
    return None, min(max(longer, LEAST), 0.5)


def _midpoint(derivative: Callable, t, y: np.ndarray, slope: np.ndarray, h, substeps: int) -> np.ndarray:
    """The modified midpoint rule with Gragg's last step; its error has even powers of h only.

    The last step evaluates the derivative at the step's end (Hairer, Norsett & Wanner, II.9.13c): without it a force
    that sets in between the last two substeps would be seen by none of the columns.
    """
    small = h / substeps
    before, now = y, y + small * slope
    for k in range(1, substeps):
        before, now = now, before + 2 * small * derivative(t + k * small, now)
    return (before + now + small * derivative(t + h, now)) / 2


FIRST_STEP = 1e-3  # s, where forces set in or end
RESOLUTION = 1e-15  # s, to which a change of branch is located
MOST_CHANGES = 20_000
# Of max(1, |y|). Below, a step's last columns differ by roundoff, and shorter steps add more of it than they save.
TOLERANCES = {float: 1e-12, np.longdouble: 1e-16}


def extrapolate(
    derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float, switches: Callable | None = None
) -> np.ndarray:
    """Integrate y' = derivative(t, y) from times[0]; return y at `times`, shape (n_t, n), in start's precision.

    Modified midpoint rule, substeps 2, 4, 6, ... (Hairer, Norsett & Wanner, Solving ODEs I, II.9). `tolerance` is
    relative to max(1, |y|). With `switches`, y' = derivative(t, y, on) and on = switches(t, y) > 0, held within a step:
    a step in which a switch changes sign is cut just past the first change. Raises NoConvergenceError with the time
    where steps or branches do not come to an end.
    """
    states = np.empty((len(times), len(start)), dtype=start.dtype)
    states[0] = y = start
    t, step, changes = start.dtype.type(times[0]), start.dtype.type(FIRST_STEP if switches else 0.05), 0
    on, pace = None if switches is None else switches(t, y) > 0.0, Pace(times)
    for k, goal in enumerate(times[1:].astype(start.dtype), start=1):
        while t < goal:
            pace.check(float(t))
            whole = step >= goal - t
            h = goal - t if whole else step
            slope = partial(derivative, on=on) if switches else derivative
            ahead, factor = attempt(slope, t, y, h, tolerance)
            if ahead is None:
                step = h * factor
                if step < SMALLEST_STEP:
                    raise NoConvergenceError(f"extrapolation stalls at t = {float(t):.6g} s")
                continue
            if switches is not None and np.any((switches(t + h, ahead) > 0.0) != on):
                h, ahead = _cut(slope, switches, on, t, y, h, ahead, tolerance)
                changes += 1
                if changes > MOST_CHANGES:
                    raise NoConvergenceError(f"forces begin and end without limit at t = {t:.6g} s")
                t, y = t + h, ahead
                on = switches(t, y) > 0.0
                continue
            t, y = goal if whole else t + h, ahead
            step = max(step, h * factor) if h < step else h * factor
        states[k] = y
    return states


def _cut(slope, switches, on, t, y, h, ahead, tolerance) -> tuple[float, np.ndarray]:
    """Return the first step after which a switch has changed, and the state there, by Brent's method."""
    past, changing = (h, ahead), (switches(t + h, ahead) > 0.0) != on

    def margin(step: float) -> float:
        """Return how far the nearest switch is from its change, negative beyond it and never 0."""
        nonlocal past
        there = ahead if step == h else y if step == 0.0 else attempt(slope, t, y, step, tolerance)[0]
        if there is None:
            raise NoConvergenceError(f"extrapolation stalls at t = {t:.6g} s")
        values = switches(t + step, there)
        changed = (values > 0.0) != on
        if not changed.any():
            return max(float(np.abs(values[changing]).min()), RESOLUTION)
        past = (step, there) if step < past[0] else past
        return -max(float(np.abs(values[changed]).max()), RESOLUTION)

    scipy.optimize.root_scalar(margin, bracket=(0.0, float(h)), xtol=RESOLUTION, rtol=4.0 * EPS)
    return past


TIGHTEST = {"Radau": 1e-12}  # its steps are of order 5: tighter ones cost minutes


def _by_scipy(name: str, derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Integrate y' = derivative(t, y) from times[0]; return y at `times`, shape (n_t, n). Raises NoConvergenceError.

    The solver of that name is stepped onto every time: its dense output is of lower order.
    """
    states, step, pace = np.empty((len(times), len(start))), None, Pace(times)
    states[0], tolerance = start, max(tolerance, TIGHTEST.get(name, 0.0))
    for k in range(1, len(times)):
        first = None if step is None else min(step, times[k] - times[k - 1])
        solver = getattr(scipy.integrate, name)(
            derivative, times[k - 1], states[k - 1], times[k], rtol=tolerance, atol=tolerance, first_step=first
        )
        while solver.status == "running":
            pace.check(solver.t)
            message = solver.step()
            if solver.status == "failed":
                raise NoConvergenceError(f"{name} stops at t = {solver.t:.6g} s: {message}")
        states[k], step = solver.y, getattr(solver, "h_abs", None)  # LSODA hides its own
    return states


runge_kutta = partial(_by_scipy, "DOP853")
lsoda, radau = partial(_by_scipy, "LSODA"), partial(_by_scipy, "Radau")  # for stiff motions


STAGES = 14
MOST_SWEEPS = 60
ROUNDOFF = 4 * float(np.finfo(np.longdouble).eps)  # of a sweep


def collocate(
    acceleration: Callable, place: np.ndarray, rate: np.ndarray, times: np.ndarray, tolerance: float,
    seen: Callable[[np.ndarray], None] = lambda x: None,
) -> np.ndarray:  # fmt: skip
    """Return y (n_t, ...) at `times`; `acceleration` takes m instants at once: t (m,), y and y' (m, ...).

    The acceleration is a Legendre series over each step; a step holds where the last term of the series, times the
    step, is below `tolerance` of max(1, |y|, |y'|). That is the error of the stages; the end's is of twice the
    order where forces are smooth, and no worse where they are not. `seen` is given the stages (m, ...) of every
    step that holds. Raises NoConvergenceError.
    """
    result = np.empty((len(times), *place.shape), dtype=np.longdouble)
    result[0] = place
    t, step, pace = np.longdouble(times[0]), np.longdouble(0.05), Pace(times)
    for k, goal in enumerate(times[1:].astype(np.longdouble), start=1):
        while t < goal:
            pace.check(float(t))
            h = min(step, goal - t)
            stages, force, last = _attempt(acceleration, t, place, rate, h, tolerance)
            factor = min(2.0, 0.9 * (tolerance / max(last, 1e-30)) ** (1 / STAGES))
            if last > tolerance:
                step = h * max(0.1, factor)
                if step < SMALLEST_STEP:
                    raise NoConvergenceError(f"collocation stalls at t = {float(t):.6g} s")
                continue
            seen(stages)
            _, weights, double = coefficients()[:3]
            place = place + h * rate + h**2 * np.tensordot(double, force, axes=1)
            rate = rate + h * np.tensordot(weights, force, axes=1)
            step = max(step, h * factor) if h < step else h * factor
            t = goal if h == goal - t else t + h
        result[k] = place
    return result


def _attempt(acceleration, t, place, rate, h, tolerance) -> tuple[np.ndarray, np.ndarray, float]:
    """Return stages, their accelerations, and the size of the series' last term; infinite where sweeps do not end."""
    nodes, _, _, once, twice, highest = coefficients()
    shape = (-1, *(1,) * place.ndim)
    at = t + h * nodes
    moved = place + (h * nodes).reshape(shape) * rate
    scale = max(1.0, float(np.abs(place).max()), float(np.abs(rate).max()))
    stages, force, before = moved, np.zeros_like(moved), np.inf
    for _ in range(MOST_SWEEPS):
        stages = moved + h**2 * np.tensordot(twice, force, axes=1)
        new = acceleration(at, stages, rate + h * np.tensordot(once, force, axes=1))
        change, force = float(h * np.abs(new - force).max()), new
        if not change < 1e6 * scale:
            break
        if change <= ROUNDOFF * scale or (change >= before and change <= 1e3 * ROUNDOFF * scale):
            last = float(h * np.abs(np.tensordot(highest, force, axes=1)).max())
            return stages, force, last / scale
        before = change
    return stages, force, np.inf


@lru_cache(maxsize=1)
def coefficients() -> tuple[np.ndarray, ...]:
    """Return nodes c, weights b, b (1 - c), matrices A and A A, and what takes stages to the last Legendre term."""
    s, (x, weights) = STAGES, legendre(STAGES)
    weights = weights / 2  # of [0, 1]
    values = np.array([np.polynomial.legendre.legval(x, [0] * n + [1]) for n in range(s + 1)], dtype=np.longdouble)
    # of a series sum a_n P_n: a_n = (2n + 1) sum_i b_i P_n(x_i) f_i; and int P_n = (P_(n+1) - P_(n-1)) / (2n + 1)
    analysis = (2 * np.arange(s, dtype=np.longdouble) + 1)[:, None] * values[:s] * weights
    integral = np.array([1 + x, *((values[n + 1] - values[n - 1]) / (2 * n + 1) for n in range(1, s))]) / 2
    once = integral.T @ analysis
    c = (1 + x) / 2
    return c, weights, weights * (1 - c), once, once @ once, analysis[-1]
