"""The probability that a method converges to the truth, from the errors of its runs and the gaps between them.

A run at setting s ends at x(s) = x_true + D + C s^p z: d = |D| is the distance of the method's own limit from the
truth, p the order and z a direction of size about 1 whose length scatters by `sigma` decades. Four hypotheses explain
the same errors e_i and gaps g_ij, each datum once, as products of densities of log10 distances:

    right     D = 0: errors follow the law; a gap follows from the two errors
    limit     D > 0: gaps between neighbours follow the law; the finest error states d; the other errors follow from it
    plateau   outputs or events set the steps at all runs so far: equal errors, and the law is not visible yet
    stalled   errors follow the law, and the last ones do not fall: they lie about a level, in random directions

Right and limit admit first runs that are not on the law, plateaus before it and stray runs. Known contributions enter
as known: the truth's uncertainty in errors, rounding in errors and gaps. Densities are Student's t with 4 degrees of
freedom; below two widths they fall as the distance itself, for a vector is short by k decades with odds 10^-k only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.truths.truth import ONE_FIGURE

# Priors. Calibrated on synthetic ladders (docs/theory.md); none refers to a scene or an engine.
PRIORS = {"right": 0.62, "limit": 0.25, "plateau": 0.04, "stalled": 0.09}
STRAY = 0.03  # probability that a run lies anywhere, off the law
REPEATING = 0.2  # probability that runs of a stalled method may end in the same place: both miss the same event, say
REPEATED = 0.5  # ... and that a run then ends where the one before did
LATE = 0.15  # probability that the first run is not on the law; halves with every further run
FADE = {"fixed": 0.5, "adaptive": 2.0}  # decades of the setting over which a plateau becomes less likely by e
REAL = np.float32  # of the sums over the grid: odds need three figures
WIDTHS = np.array([0.03, 0.12, 0.12, 0.35, 0.7], REAL)  # sigma: scatter about the law, decades
ALIGNED = np.array([True, True, False, False, False])  # whether z keeps its direction
SCATTER = {"fixed": (0.35, 0.25, 0.20, 0.15, 0.05), "adaptive": (0.05, 0.15, 0.30, 0.35, 0.15)}
UNUSUAL = 0.02  # probability that the error at the reference setting may be anything
SPAN = 19.0  # decades over which a stray run's error may lie

AMPLITUDES = np.arange(-18.0, 6.0, 0.25)  # log10 of the law at the finest run
DISTANCES = np.arange(-10.0, 0.8, 0.125)  # log10 of d
LEVELS = np.arange(-16.0, 4.0, 0.25).astype(REAL)  # log10 of the level at which errors stall
LOG_10 = math.log(10.0)
TINY = 1e-18  # over the scene's scales: an error or gap below is below any rounding
COMMON = 1e-2  # of the smallest error: rounding above this matters, and its size and growth are uncertain
KNOWN = 0.25  # of the order, or of 1: a wider interval shows no order
ROUNDINGS = ((0.03, 1.0), (0.3, 1.0), (3.0, 1.0), (0.1, 0.5), (1.0, 0.5), (10.0, 0.5))  # factor, power of the steps
ROUNDED = max(factor for factor, _ in ROUNDINGS)  # rounding may explain an error up to so many times its stated size


@dataclass(frozen=True)
class Posterior:
    """Probabilities over hypotheses, orders, amplitudes and distances of the method's own limit."""

    ladder: Ladder  # levels, coarse to fine
    weights: dict[str, float]  # of the hypotheses, sum 1
    orders: np.ndarray  # (n_p,)
    law: np.ndarray  # (n_p, n_b) of order and amplitude, under right and limit; sum 1
    distance: np.ndarray  # (n_d,) of DISTANCES under limit; sum 1
    level: np.ndarray  # (n_l,) of LEVELS under stalled; sum 1

    def odds_of_limit(self, above: float) -> float:
        """Return the probability that the method's own limit is farther than `above` from the truth."""
        return self.weights["limit"] * float(self.distance[np.log10(max(above, TINY)) < DISTANCES].sum())

    def odds_of_stall(self, above: float) -> float:
        """Return the probability that errors stall above a level."""
        return self.weights["stalled"] * float(self.level[np.log10(max(above, TINY)) < LEVELS].sum())

    def odds_of_order_below(self, order: float) -> float:
        """Return the probability that a law with less than an order holds, if one holds."""
        return float(self.law.sum(axis=1)[self.orders < order].sum())

    @property
    def limit_distance(self) -> float:
        """The distance of the method's own limit from the truth, if it has one: the median."""
        ends = DISTANCES + 0.5 * (DISTANCES[1] - DISTANCES[0])  # of the grid's cells
        return float(10.0 ** np.interp(0.5, np.cumsum(self.distance), ends))

    @cached_property
    def order(self) -> float:
        """The most probable order: the mean of the fourth power of its density, on a finer grid about the maximum."""
        p, b = np.unravel_index(int(np.argmax(self.law)), self.law.shape)
        ratio = self.orders[1] / self.orders[0]
        orders = self.orders[p] * ratio ** np.linspace(-2.0, 2.0, 61)
        amplitudes = AMPLITUDES[b] + np.linspace(-0.5, 0.5, 41)
        data = _Data(self.ladder, orders, amplitudes)
        if np.isfinite(self.ladder.errors).all():
            law = self.weights["right"] * _right(data)[1] + self.weights["limit"] * _limit(data)[1]
        else:
            law = _by_gaps(data)[1]
        weight = ((law / law.max()) ** 4).sum(axis=1)
        return float(weight @ orders / weight.sum())

    @property
    def observed_order(self) -> float | None:
        """The order where two runs or more follow the law and its central 68 % span less than KNOWN; else None."""
        total = np.cumsum(self.law.sum(axis=1))
        low, high = self.orders[np.minimum(np.searchsorted(total, [0.16, 0.84]), len(self.orders) - 1)]
        follows = len(self.ladder) > 1 and self.weights["right"] + self.weights["limit"] > 0.5
        return self.order if follows and high - low < KNOWN * max(1.0, self.order) else None


def posterior(ladder: Ladder) -> Posterior:
    """Return what the runs show. ValueError where there is none."""
    if not len(ladder):
        raise ValueError("ladder = (): a posterior needs one run at least")
    levels = ladder.levels()
    known, sizes = levels.errors[np.isfinite(levels.errors)], [levels.rounding]
    if np.any(levels.rounding > COMMON * max(float(np.min(known, initial=np.inf)), TINY)):
        growth = np.maximum(levels.steps, 1)
        sizes = [factor * levels.rounding * growth ** (power - 1.0) for factor, power in ROUNDINGS]
    totals, parts = zip(*[_evidence(replace(levels, rounding=size)) for size in sizes], strict=True)
    share = np.exp(np.array(totals) - _log_sum(totals))
    weights = {name: float(share @ [part.weights[name] for part in parts]) for name in PRIORS}
    every = [np.tensordot(share, [getattr(part, name) for part in parts], 1) for name in ("law", "distance", "level")]
    return Posterior(levels, weights, parts[0].orders, *(each / each.sum() for each in every))


def _log_sum(logs: Any, axis: int | tuple[int, ...] | None = None) -> np.ndarray:
    """Return the log of a sum of exponentials."""
    logs = np.asarray(logs)
    largest = np.maximum(np.max(logs, axis=axis, keepdims=True), -1e30)  # finite, for a sum of zeros
    with np.errstate(divide="ignore"):
        return np.log(np.sum(np.exp(logs - largest), axis=axis)) + np.squeeze(largest, axis=axis)


def density(value: np.ndarray, centre: np.ndarray, width: np.ndarray | float) -> np.ndarray:
    """Return the log density of a log10 distance per decade."""
    z = (value - centre) / width
    short = np.minimum(value - centre + 2.0 * width, 0.0) * LOG_10
    return np.log(0.375 / width) - 2.5 * np.log(1.0 + 0.25 * z * z) + short


def _derived(value: np.ndarray, first: np.ndarray, second: np.ndarray, floor: np.ndarray | float = 0.0) -> np.ndarray:
    """Return the log density of a distance whose two parts have known lengths and unknown directions."""
    square = first**2 + second**2
    width = np.hypot(0.06, 0.6 * first * second / np.maximum(square, TINY**2))
    return density(value, 0.5 * np.log10(square + np.square(floor) + TINY**2), width)


def _on_grid(values: Any) -> np.ndarray:
    """Return values of modes or runs for every point of the grid, (..., 1, 1)."""
    return np.asarray(values, REAL)[..., None, None]


def _tails(logs: np.ndarray) -> np.ndarray:
    """Return the sums from each run on, in place; runs are the third axis from the end."""
    for run in range(logs.shape[-3] - 2, -1, -1):
        logs[..., run, :, :] += logs[..., run + 1, :, :]
    return logs


def _mix(log_density: np.ndarray, share: float) -> np.ndarray:
    """Return a log density with a share of strays, which may lie anywhere."""
    return np.log((1.0 - share) * np.exp(log_density) + share / SPAN)


def _grid(expected: float) -> np.ndarray:
    """Return the orders (n_p,) that are possible where one is expected."""
    return np.geomspace(0.25 * min(expected, 1.0), max(1.6 * expected, expected + 3.0), 33)


def _order_prior(grid: np.ndarray, expected: float) -> np.ndarray:
    """Return the log probabilities (n_p,) of orders."""
    x = np.log(grid)
    bell = np.exp(-0.5 * ((x - np.log(expected)) / 0.15) ** 2)
    first = np.exp(-0.5 * (x / 0.15) ** 2) if expected > 1.0 else bell
    flat = np.where(grid < 0.4, 0.25, 1.0)
    return np.log(0.68 * bell / bell.sum() + 0.12 * first / first.sum() + 0.2 * flat / flat.sum())


def saturated(log_amplitude: np.ndarray, bound: float) -> np.ndarray:
    """Return the size of a difference of a given amplitude: motions are no farther apart than `bound`."""
    amplitude = 10.0 ** np.minimum(log_amplitude, 12.0)
    return amplitude / (1.0 + amplitude / bound)


class _Data:
    """Log densities of each datum under the law: of modes (m), runs (i), and a grid of orders (p), amplitudes (b)."""

    def __init__(self, ladder: Ladder, orders: np.ndarray | None = None, amplitudes: np.ndarray = AMPLITUDES) -> None:
        n, bound = len(ladder), ladder.bound  # a run that has blown up is as far off as motions go
        ladder = replace(ladder, errors=np.minimum(ladder.errors, bound), gaps=np.minimum(ladder.gaps, bound))
        self.ladder, self.n = ladder, n
        self.orders, self.amplitudes = _grid(ladder.order) if orders is None else orders, amplitudes
        log_order = _order_prior(self.orders, ladder.order)
        self.log_setting = np.log10(ladder.settings)
        reach = self.orders * (self.log_setting - self.log_setting[-1])[:, None]  # (i, p)
        amplitude = saturated(self.amplitudes + reach[..., None], ladder.bound).astype(REAL)  # (i, p, b)
        self.hidden = ONE_FIGURE * ladder.uncertainty  # a smaller error is only known to lie below
        self.errors = np.fmax(ladder.errors, max(TINY, self.hidden))
        self.log_error = np.log10(self.errors).astype(REAL)
        self.is_hidden = ladder.errors <= self.hidden
        self.rounding = np.hypot(ladder.rounding[:-1], ladder.rounding[1:])  # (n - 1,) of the gap to the next run
        self.gaps = np.maximum(np.diagonal(ladder.gaps, 1), np.maximum(self.rounding, TINY))  # (n - 1,) likewise
        self.log_gap = np.log10(self.gaps).astype(REAL)
        to_finest = np.maximum(ladder.gaps[: max(n - 2, 0), -1], np.maximum(ladder.rounding[-1], TINY))
        self.log_far = np.log10(to_finest).astype(REAL)  # (n - 2,) of the gaps to the finest run
        self.far_by_gaps = self._far_by_gaps().astype(REAL)
        prior = log_order[:, None] + self._amplitude_prior() + np.log(SCATTER[ladder.kind])[:, None, None]
        self.prior = prior.astype(REAL)[:, None]  # (m, 1, p, b)
        self.amplitude = amplitude
        self.by_law = self._errors_by_law(amplitude)  # (m, i, p, b)
        self.gaps_by_law = self._gaps_by_law(amplitude)  # (m, i, p, b) of i and i + 1
        self.gaps_by_errors = self._gaps_by_errors().astype(REAL)  # (m, i)

    def _amplitude_prior(self) -> np.ndarray:
        """Return log probabilities (p, b): the error at the reference setting is typical within decades."""
        at = self.amplitudes[None, :] + self.orders[:, None] * (np.log10(self.ladder.reference) - self.log_setting[-1])
        usual = (1.0 + 0.25 * ((at - self.ladder.typical) / self.ladder.spread) ** 2) ** -2.5
        return np.log((1.0 - UNUSUAL) * usual / usual.sum(axis=1, keepdims=True) + UNUSUAL / len(self.amplitudes))

    def _errors_by_law(self, amplitude: np.ndarray) -> np.ndarray:
        known = np.square(self.ladder.rounding) + self.ladder.uncertainty**2
        centre = 0.5 * np.log10(np.square(amplitude) + _on_grid(known) + TINY**2)
        value = density(_on_grid(self.log_error), centre, _on_grid(WIDTHS)[:, None])
        if self.is_hidden.any():
            below = np.minimum(0.0, (math.log10(self.hidden + TINY) - centre) / _on_grid(WIDTHS)[:, None])
            value = np.where(self.is_hidden[:, None, None], -2.5 * np.log(1.0 + 0.25 * below**2), value)
        return _mix(value, STRAY)

    def _gaps_by_law(self, amplitude: np.ndarray) -> np.ndarray:
        """Return densities of the gaps to the next run by the law, and of those to the finest run by two gaps."""
        coarse, fine = amplitude[:-1], amplitude[1:]
        least = _on_grid(np.square(self.rounding)) + TINY**2
        turned = coarse * fine * np.square(fine / self.ladder.bound)  # motions far apart have unrelated directions
        along = 0.5 * np.log10(np.square(coarse - fine) + turned + least)
        across = 0.5 * np.log10(np.square(coarse) + np.square(fine) + least)
        centre = np.stack([along if aligned else across for aligned in ALIGNED])
        next_one = _mix(density(_on_grid(self.log_gap), centre, _on_grid(WIDTHS)[:, None]), 2.0 * STRAY)
        return next_one + _on_grid(self.far_by_gaps)

    def _gaps_by_errors(self) -> np.ndarray:
        """Return densities (m, i) of the gaps from run i to the next and to the finest run, by their errors."""
        next_one = self._apart(self.log_gap, self.errors[:-1], self.errors[1:], self.rounding)
        both = self.is_hidden[:-1] & self.is_hidden[1:]
        next_one = np.where(both, -np.log(SPAN), next_one)
        if self.n > 2:
            rounding = np.hypot(self.ladder.rounding[:-2], self.ladder.rounding[-1])
            far = self._apart(self.log_far, self.errors[:-2], self.errors[-1], rounding)
            hidden = self.is_hidden[:-2] & self.is_hidden[-1]
            next_one[:, :-1] += np.where(hidden, -np.log(SPAN), far)
        return next_one

    def _apart(self, log_gap: np.ndarray, first: np.ndarray, second: np.ndarray, rounding: np.ndarray) -> np.ndarray:
        """Return densities (m, i) of gaps between runs of known errors: directions differ as lengths scatter."""
        across = _derived(log_gap, first, second, rounding)
        turn = WIDTHS[:, None] * np.log(10.0)  # rad
        length = np.sqrt((first - second) ** 2 + first * second * turn**2 + rounding**2)
        width = np.hypot(0.06, 0.6 * first * second / (first**2 + second**2))
        along = density(log_gap, np.log10(length + TINY), width)
        mixed = np.logaddexp(np.log1p(-2.0 * STRAY) + along, np.log(2.0 * STRAY) + across)
        return np.where(ALIGNED[:, None], mixed, across)

    def _far_by_gaps(self) -> np.ndarray:
        """Return densities (m, i) of the gaps to the finest run by those to the next run and from there."""
        far = np.zeros((len(WIDTHS), max(self.n - 1, 0)))
        if self.n > 2:
            first, second = self.gaps[:-1], 10.0 ** np.append(self.log_far[1:], self.log_gap[-1])
            across = _derived(self.log_far, first, second)
            width = np.hypot(0.06, 0.6 * first * second / (first**2 + second**2))
            along = np.logaddexp(np.log1p(-2.0 * STRAY) + density(self.log_far, np.log10(first + second), width),
                                 np.log(2.0 * STRAY) + across)  # fmt: skip
            far[:, :-1] = np.where(ALIGNED[:, None], along, across)
        return far

    @property
    def across(self) -> np.ndarray:
        """Log densities (n - 1,) of the gaps between runs in unrelated directions."""
        return self.gaps_by_errors[-1]

    def late(self, first: int) -> float:
        """Return the log probability that the law begins at run `first`, and the log density of the runs before."""
        start = np.log1p(-LATE) if first == 0 else np.log(LATE) + first * np.log(0.5)
        return float(start - first * np.log(SPAN) + self.across[:first].sum())

    def plateau(self, count: int) -> float:
        """Return the log density of `count` first runs as a plateau: equal errors, gaps of any size below them."""
        steps = self.log_error[1:count] - self.log_error[: count - 1]
        decades = self.log_setting[0] - self.log_setting[count - 1]
        depth = self.log_error[: count - 1] - self.log_gap[: count - 1]
        below = np.where((depth > -0.3) & (depth < 8.0), -np.log(8.0), -np.log(1e4))
        far = self.far_by_gaps[-1, : count - 1].sum()
        return float(-np.log(SPAN) + density(steps, np.zeros(1), 0.1).sum() + below.sum() + far
                     - decades / FADE[self.ladder.kind])  # fmt: skip


def _evidence(ladder: Ladder) -> tuple[float, Posterior]:
    """Return the log evidence under one size of rounding, and what it shows; the law's sum is that of its weights."""
    data = _Data(ladder)
    if not np.isfinite(ladder.errors).all():
        return _without_truth(data)
    right, law_right = _right(data)
    limit, law_limit, distance = _limit(data)
    stalled, level = _stalled(data)
    plateau = data.plateau(data.n) if data.n > 1 else -np.log(SPAN)
    total, weights = _weighed({"right": right, "limit": limit, "plateau": plateau, "stalled": stalled})
    law = weights["right"] * law_right + weights["limit"] * law_limit
    return total, Posterior(ladder, weights, data.orders, law, distance, level)


def _weighed(logs: dict[str, float]) -> tuple[float, dict[str, float]]:
    """Return the log evidence of all hypotheses, and their probabilities; those without evidence have none."""
    every = {name: float(logs.get(name, -np.inf) + np.log(prior)) for name, prior in PRIORS.items()}
    total = float(_log_sum(list(every.values())))
    return total, {name: float(np.exp(value - total)) for name, value in every.items()}


def _right(data: _Data) -> tuple[float, np.ndarray]:
    """Return the log evidence that the method converges to the truth, and the posterior of order and amplitude."""
    terms = data.by_law.copy()
    terms[:, :-1] += _on_grid(data.gaps_by_errors)
    starts = [data.late(first) for first in range(data.n)]
    if data.n > 2:  # a plateau of two runs or more, then the law
        ends = [data.plateau(count) + data.across[count - 1] + np.log(LATE) for count in range(2, data.n)]
        starts[2:] = np.logaddexp(starts[2:], ends).tolist()
    return _summed(data.prior + _tails(terms) + _on_grid(starts))


def _limit(data: _Data) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the log evidence of a limit off the truth, the posterior of order and amplitude, and of its distance."""
    finest = data.amplitude[-1, 0]
    known = float(np.hypot(data.ladder.rounding[-1], data.ladder.uncertainty))
    distance = 10.0**DISTANCES
    last = _derived(data.log_error[-1], finest[:, None], distance[None, :], known)  # (b, d)
    if data.is_hidden[-1]:
        last = np.where(np.hypot(finest[:, None], distance) <= data.hidden, 0.0, last - np.log(SPAN))
    to_finest = np.maximum(data.ladder.gaps[:-1, -1], np.maximum(data.ladder.rounding[-1], TINY))
    others = _mix(_derived(data.log_error[:-1], data.errors[-1], to_finest, known), STRAY)
    others = np.where(data.is_hidden[:-1], -np.log(SPAN), others)
    gaps = np.zeros_like(data.by_law)
    gaps[:, :-1] = data.gaps_by_law + _on_grid(others)
    starts = [data.late(first) for first in range(data.n)]
    weight = _log_sum(data.prior + _tails(gaps) + _on_grid(starts), axis=(0, 1))  # (p, b)
    by_distance = _log_sum(weight, axis=0)[:, None] + last - np.log(len(DISTANCES))
    total = float(_log_sum(by_distance))
    law = np.exp(weight + (_log_sum(last, axis=1) - np.log(len(DISTANCES)))[None, :] - total)
    return total, law, np.exp(_log_sum(by_distance, axis=0) - total)


def _stalled(data: _Data) -> tuple[float, np.ndarray]:
    """Return the log evidence that errors stall, grow, or lie at random heights, and the posterior of their level.

    The last runs scatter about a level by 0.12 to 1.5 decades; those before may follow the law, to far below it.
    Directions are random, or there are few of them, and runs that take the same one are equal.
    """
    n = data.n
    widths = np.array([0.12, 0.35, 0.7, 1.5], REAL)
    drift = np.array([0.0, -0.5, -1.0], REAL)  # order of the level in the setting: errors may grow with refinement
    tilt = drift[:, None] * (data.log_setting - data.log_setting[-1])  # (order, i)
    centre = np.log10(saturated(LEVELS + tilt[..., None], data.ladder.bound)).astype(REAL)  # (order, i, l)
    alone = density(data.log_error[:, None], centre[:, None], widths[:, None, None])  # (order, width, i, l)
    per_run = np.stack([alone, alone], axis=2)  # (order, width, repeats, i, l)
    per_run[..., :-1, :] += np.array([data.across, _mix(data.across, REPEATED)])[..., None]
    prior = np.log(np.array([0.7, 0.2, 0.1]))[:, None, None] + np.log([1.0 - REPEATING, REPEATING])
    prior -= np.log(len(widths) * len(LEVELS) * n)
    heads = np.cumsum(data.by_law[:, :-1] + _on_grid(data.gaps_by_errors), axis=1)
    before = np.append(0.0, _log_sum(data.prior + heads, axis=(0, 2, 3)))
    logs = _log_sum(_tails(per_run[..., None])[..., 0] + prior[..., None, None] + before[:, None], axis=(0, 1, 2, 3))
    total = float(_log_sum(logs))
    return total, np.exp(logs - total)


def _by_gaps(data: _Data) -> tuple[float, np.ndarray]:
    """Return the log evidence that gaps follow the law, and the posterior of order and amplitude."""
    return _summed(data.prior + data.gaps_by_law.sum(axis=1, keepdims=True))


def _without_truth(data: _Data) -> tuple[float, Posterior]:
    """Return the evidence of the gaps alone: they follow the law, or do not shrink."""
    right, law = _by_gaps(data)
    apart = density(data.log_gap, LEVELS[:, None], 0.35).sum(axis=-1) - np.log(len(LEVELS))
    stalled = float(_log_sum(apart))
    total, weights = _weighed({"right": right, "stalled": stalled})
    flat = np.full(len(DISTANCES), 1.0 / len(DISTANCES))
    return total, Posterior(data.ladder, weights, data.orders, law, flat, np.exp(apart - stalled))


def _summed(logs: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the log of a sum over modes, runs and grid, and the probabilities of order and amplitude (p, b)."""
    total = float(_log_sum(logs))
    return total, np.exp(_log_sum(logs, axis=(0, 1)) - total)
