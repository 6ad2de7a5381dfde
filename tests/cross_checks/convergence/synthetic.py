"""Synthetic methods with known answers, in two families: for the calibration of verdicts, and for their test.

Common to both families: 60 % take fixed steps over 1 to 20 s, 40 % a tolerance. Orders are 1 to 12, half of them 1, 2
or 4. The error reaches the size of the scene at a step of 0.025 to 0.5 s, or is 0.6 to 40 times the tolerance. One
fixed-step method in five shows another order than the documented one: one more, one less, or 1. Errors of fixed steps
are nearly aligned and scatter by 0.003 to 0.16 decades; those of tolerances turn and scatter by 0.05 to 0.35 decades.
Scatter is continuous over 0.1 to 1 decade of the setting. Rounding leaves 0.03 to 5 times roundoff x amplification x
steps (or their root, by half). The stated amplification, mostly 1 to 10, is right to a factor of 2. Truths are known to
1e-15 to 1e-10, one in ten to 1e-7 at worst. Errors saturate at twice the scene. Steps of a tolerance are
rtol^(-1/(p+1)) times a constant, at least one for each of 40 outputs; runs that outputs alone determine are equal bit
by bit.

CALIBRATION is family A, HELD_OUT family B: their categories with shares. The docstring of each change describes its
distribution. In both families 74 % of the methods are correct, 20 % have a wrong limit and 6 % never converge. A wrong
limit is log-uniform from twice the bar to 0.5; whether runs settle within a tenth of it, or it remains hidden below
their errors, follows from the other numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from cross_checks.engine import SINGLE
from tests.cross_checks.convergence.law import OUTPUTS, WHITE, Draft, Label, SyntheticMethod, complete

BAR = 1e-6  # of the scene: a limit beyond this, and beyond TENFOLD the truth's uncertainty, is wrong
TENFOLD = 10.0
ORDERS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
SHARES = (0.15, 0.22, 0.1, 0.2, 0.1, 0.06, 0.09, 0.04, 0.04)  # of these orders


def scattered(draft: Draft) -> None:
    """Scatter by 0.3 to 0.7 decades, in directions that change."""
    draft.scatter, draft.turning, draft.width = draft.uniform(0.3, 0.7), 1.0, draft.power_of_ten(-2.0, -0.5)


def floor(draft: Draft) -> None:
    """End at a floor of 1e-13 to 3e-7 of constant or of changing direction."""
    height = draft.power_of_ten(-13.0, -6.6)
    if draft.chance(0.5):
        draft.limit = height
    else:
        draft.add(lambda x, steps: height)


def pre_asymptotic(draft: Draft) -> None:
    """Follow another order at the coarse end: 0 to 3 times the later one, from 60 to 600 steps upward."""
    begin, slope = draft.within(1.8, 2.8), draft.uniform(-1.0, 2.0) * draft.power
    draft.add_aligned(lambda x: 10.0 ** min(slope * max(0.0, x - begin), 30.0) - 1.0)


def by_step(draft: Draft) -> None:
    """Take a fixed step instead of a tolerance."""
    if draft.kind == "adaptive":
        draft.kind, draft.power, draft.reach = "fixed", float(draft.order), draft.uniform(-1.6, -0.3)
        draft.height -= 1.2


def by_tolerance(draft: Draft) -> None:
    """Take a tolerance instead of a fixed step."""
    if draft.kind == "fixed":
        draft.kind, draft.order = "adaptive", max(2, draft.order)
        draft.embedded, draft.power, draft.reach = draft.order, draft.order / (draft.order + 1.0), 0.0
        draft.height += 1.2
        draft.scatter, draft.turning = draft.uniform(0.05, 0.35), draft.uniform(0.2, 1.0)


def plateau(draft: Draft) -> None:
    """Let outputs, or events, determine the steps above a tolerance of 1e-3 to 1e-8, at an error of 1e-7 to 0.3."""
    by_tolerance(draft)
    draft.plateau = draft.reach = draft.uniform(-8.0, -3.0)
    draft.height = draft.uniform(-7.0, -0.5)
    if draft.chance(0.5):  # outputs: no tolerance above changes anything
        draft.first_steps = OUTPUTS * 10.0 ** (draft.plateau / (draft.embedded + 1.0))
    else:
        draft.creep = draft.uniform(0.0, 0.05)


def single(draft: Draft) -> None:
    """Compute in single precision; a tolerance near roundoff often fails."""
    draft.roundoff = SINGLE
    if draft.kind == "adaptive" and draft.chance(0.6):
        tightest = draft.uniform(-8.0, -6.0)
        draft.failures.append(lambda x: "step-too-small" if x < tightest else "")


def failing(draft: Draft) -> None:
    """Refuse or fail at coarse settings, at fine ones, or at random ones."""
    coarse, fine, which = draft.within(1.8, 3.0), draft.within(3.0, 4.8), draft.rng.integers(3)
    word = str(draft.rng.choice(["non-finite", "not-converged", "cannot", "timeout"]))
    if which == 2:
        random_failures(draft)
    else:
        draft.failures.append(lambda x: word if (x > coarse if which else x < fine) else "")


def random_failures(draft: Draft) -> None:
    """Fail at one setting in ten to one in three, for various reasons."""
    last = "step-too-small" if draft.kind == "adaptive" else "cannot"
    least, words = draft.uniform(0.43, 1.28), ("non-finite", "not-converged", "timeout", last)

    def failure(x: float) -> str:
        numbers = draft.noise(7, x, WHITE)
        return words[int(10.0 * abs(numbers[1])) % 4] if numbers[0] > least else ""

    draft.failures.append(failure)


def outlier(draft: Draft) -> None:
    """Lose one run in fifteen: its error is 1e-3 to 1 by chance."""

    def height(x: float, steps: int) -> float:
        numbers = draft.noise(8, x, WHITE)
        return 10.0 ** min(0.0, -1.5 + numbers[1]) if numbers[0] > 1.5 else 0.0

    draft.add(height)


def chaos(draft: Draft) -> None:
    """Amplify errors by 1e3 to 1e11; truth and rounding share in it."""
    draft.amplification, draft.width = draft.power_of_ten(3.0, 11.0), draft.power_of_ten(-2.0, -1.0)
    draft.height += math.log10(draft.amplification)
    draft.uncertainty = max(draft.uncertainty, 1e-16 * draft.amplification)


def stiffened(draft: Draft) -> None:
    """Yield in constraints whose stiffness grows as 1/s or 1/s^2: first or second order by that."""
    by_step(draft)
    power, height = draft.rng.integers(1, 3), draft.uniform(-3.0, -0.5)
    draft.add(lambda x, steps: 10.0 ** (height + power * (x + 1.0)), math.inf)


def wrong(draft: Draft, low: float = -math.inf, high: float = math.log10(0.5)) -> None:
    """Converge to a limit of its own, log-uniform from twice the bar (10^low where that is more) to 10^high."""
    least = math.log10(2.0 * max(BAR, TENFOLD * draft.uncertainty))
    draft.limit = draft.power_of_ten(max(least, low), high)


def hindered(draft: Draft) -> None:
    """Take one of the difficulties of correct methods."""
    difficulties = (scattered, pre_asymptotic, plateau, failing, outlier, single)
    difficulties[draft.rng.integers(len(difficulties))](draft)


def random_heights(draft: Draft) -> None:
    """Err by anything within one to three decades, whatever the setting, above 1e-5."""
    low, draft.height = draft.uniform(-5.0, -1.5), -60.0
    high = min(low + draft.uniform(1.0, 3.0), 0.3)
    draft.add(lambda x, steps: 10.0 ** (low + (high - low) * (0.5 + 0.5 * math.erf(draft.normal(8, x) / 2.0**0.5))))


def lost(draft: Draft) -> None:
    """Converge down to a setting, and be off by 1e-4 to 1 at all finer ones."""
    end = draft.within(2.3, 3.8)
    height = max(draft.power_of_ten(-4.0, 0.0), min(1.0, 100.0 * draft.amplitude(end)))
    draft.add(lambda x, steps: height * 10.0 ** (0.3 * draft.normal(8, x)) if x < end else 0.0)


def diverging(draft: Draft, low: float, high: float) -> None:
    """Err by s^-q, q from `low` to `high` (a quarter of it for tolerances), from 1e-4 to 1e-2 at the coarse end on."""
    height, power, start = draft.uniform(-4.0, -2.0), draft.uniform(low, high), draft.coarse
    power *= 0.25 if draft.kind == "adaptive" else 1.0
    draft.add(lambda x, steps: 10.0 ** (height + power * (start - x)), 0.5)


def two_terms(draft: Draft) -> None:
    """Err by C1 s^p - C2 s^q: the two cancel at one setting of the range."""
    cross, power = draft.within(2.0, 4.0), draft.uniform(0.2, 0.6)
    if draft.kind == "fixed":
        draft.power, power = float(draft.order), float(draft.rng.choice([1.0, 2.0]))
    draft.add_aligned(lambda x: -(10.0 ** min(power * (x - cross), 30.0)))


def heavy_tails(draft: Draft) -> None:
    """Scatter by Student's t of two or three degrees of freedom, 0.1 to 0.35 decades, from run to run."""
    draft.tails, draft.scatter = int(draft.rng.integers(2, 4)), draft.uniform(0.1, 0.35)
    draft.width, draft.turning = WHITE, draft.uniform(0.3, 1.0)


def unstable(draft: Draft) -> None:
    """Blow up above a stability limit."""
    by_step(draft)
    limit, slope, draft.bound = draft.within(1.8, 3.2), draft.uniform(5.0, 60.0), math.inf
    draft.height = min(draft.height, draft.power * (draft.reach - limit) - 1.0)
    draft.add(lambda x, steps: 10.0 ** min(slope * (x - limit) - 1.0, 90.0) if x > limit else 0.0)


def aging(draft: Draft) -> None:
    """Blow up from 200 to 4000 steps on: the finer, the worse."""
    by_step(draft)
    first, slope, draft.bound = draft.uniform(2.3, 3.6), draft.uniform(4.0, 30.0), math.inf
    height = draft.uniform(-3.0, -1.0)
    beyond: Callable[[int], float] = lambda steps: slope * (math.log10(steps) - first)  # noqa: E731
    draft.add(lambda x, steps: 10.0 ** min(height + beyond(steps), 90.0) if beyond(steps) > 0.0 else 0.0)


def unconverged(draft: Draft) -> None:
    """End an implicit step's iteration early: the limit is approached to a hundredth or a fifteenth of itself."""
    by_step(draft)
    draft.limit = draft.limit or draft.power_of_ten(-10.0, -6.6)
    share = draft.limit * draft.power_of_ten(-2.0, -1.2)
    draft.add(lambda x, steps: share)


def embedded(draft: Draft) -> None:
    """Estimate errors by a solution of one to three orders less: the error is rtol^(p/(q+1)), steps rtol^(-1/(q+1))."""
    by_tolerance(draft)
    draft.embedded = max(1, draft.order - int(draft.rng.integers(1, 4)))
    draft.power = draft.order / (draft.embedded + 1.0)


def saw_tooth(draft: Draft) -> None:
    """Miss each of one to four contacts by the part of a step that remains: first order about h."""
    by_step(draft)
    draft.is_smooth = False
    for _ in range(draft.rng.integers(1, 5)):
        time, scale = draft.uniform(0.05, 0.95) * draft.duration, draft.power_of_ten(-1.5, 0.5)
        draft.add(lambda x, steps, time=time, scale=scale: scale * (10.0**x - time % 10.0**x), math.inf)


def reduced(draft: Draft) -> None:
    """Show order 1 or p/2 in a stiff scene, p again only where the step resolves the stiffness."""
    shown, fast = float(draft.rng.choice([1.0, max(1.0, 0.5 * draft.order)])), draft.within(3.0, 6.0)
    lower = shown if draft.kind == "fixed" else shown / (shown + 1.0)
    knee, power = draft.uniform(-3.5, -1.0) + lower * (fast - draft.coarse), draft.power
    draft.add(lambda x, steps: 10.0 ** (knee + (lower if x > fast else power) * (x - fast)), 0.5)


def single_forces(draft: Draft) -> None:
    """Evaluate forces in single precision: their roundings move the motion alike at all steps of about a decade.

    Beside the rounding of the steps, a floor of 0.1 to 10 times roundoff x amplification; below 1e-5 to 1e-7 every
    second tolerance fails.
    """
    draft.roundoff = SINGLE
    floor, weakest = SINGLE * draft.amplification * draft.power_of_ten(-1.0, 1.0), draft.uniform(-7.0, -5.0)
    draft.add(lambda x, steps: floor, 1.0)
    if draft.kind == "adaptive":
        draft.failures.append(lambda x: "not-converged" if x < weakest and draft.normal(7, x) > 0.0 else "")


def branches(draft: Draft) -> None:
    """Take one of two to four wrong turns at every setting by chance, each 1e-4 to 1 off in a direction of its own."""
    draft.height, count = -60.0, int(draft.rng.integers(2, 5))
    heights = [draft.power_of_ten(-4.0, 0.0) for _ in range(count)]

    def turn(place: int) -> Callable[[float, int], float]:
        return lambda x, steps: heights[place] if int(1e6 * abs(draft.normal(8, x))) % count == place else 0.0

    for place in range(count):
        draft.add(turn(place), math.inf)


def frozen(draft: Draft) -> None:
    """Ignore the setting: all runs are equal bit by bit."""
    draft.frozen, draft.height = draft.coarse, -60.0


class Category(NamedTuple):
    """A share of a family: methods with these changes, in this order."""

    name: str
    share: float
    label: Label
    changes: tuple[Callable[[Draft], None], ...] = ()


CALIBRATION = (
    Category("plain", 0.18, "correct"),
    Category("scatter", 0.10, "correct", (scattered,)),
    Category("floor", 0.07, "correct", (floor,)),
    Category("pre-asymptotic", 0.07, "correct", (pre_asymptotic,)),
    Category("plateau", 0.09, "correct", (plateau,)),
    Category("single precision", 0.07, "correct", (single,)),
    Category("failing settings", 0.05, "correct", (failing,)),
    Category("outlier", 0.03, "correct", (outlier,)),
    Category("chaos", 0.06, "correct", (chaos,)),
    Category("stiffness of the step", 0.02, "correct", (stiffened,)),
    Category("wrong limit", 0.08, "wrong-limit", (wrong,)),
    Category("difficult wrong limit", 0.06, "wrong-limit", (hindered, wrong)),
    Category("soft constraints", 0.06, "wrong-limit", (partial(wrong, low=-5.0, high=-1.0),)),
    Category("random heights", 0.02, "never", (random_heights,)),
    Category("lost", 0.02, "never", (lost,)),
    Category("diverging", 0.02, "never", (partial(diverging, low=0.5, high=2.0),)),
)
HELD_OUT = (
    Category("two terms", 0.14, "correct", (two_terms,)),
    Category("heavy tails", 0.11, "correct", (heavy_tails,)),
    Category("stability limit", 0.08, "correct", (unstable,)),
    Category("inner iterations", 0.06, "correct", (unconverged,)),
    Category("single precision of forces", 0.07, "correct", (single_forces,)),
    Category("embedded order", 0.08, "correct", (embedded,)),
    Category("saw-tooth", 0.10, "correct", (saw_tooth,)),
    Category("random failures", 0.05, "correct", (random_failures,)),
    Category("order reduction", 0.05, "correct", (reduced,)),
    Category("inner iterations, wrong", 0.06, "wrong-limit", (partial(wrong, low=-5.5, high=-2.5), unconverged)),
    Category("bitwise equal, wrong", 0.03, "wrong-limit", (frozen, wrong)),
    Category("two terms, wrong", 0.04, "wrong-limit", (two_terms, wrong)),
    Category("saw-tooth, wrong", 0.03, "wrong-limit", (saw_tooth, wrong)),
    Category("heavy tails, wrong", 0.04, "wrong-limit", (heavy_tails, wrong)),
    Category("slow divergence", 0.02, "never", (partial(diverging, low=0.05, high=0.5),)),
    Category("wrong turns", 0.02, "never", (branches,)),
    Category("instability from some step count on", 0.02, "never", (aging,)),
)


def draw(seed: int, family: tuple[Category, ...] = CALIBRATION, **known: Any) -> SyntheticMethod:
    """Return the method of a seed; fields of the draft that are `known` replace the drawn ones before any change."""
    draft = replace(_begin(seed, len(family)), **known)
    category = family[draft.rng.choice(len(family), p=[each.share for each in family])]
    for change in category.changes:
        change(draft)
    return complete(draft, category.name, category.label)


def _begin(seed: int, family: int) -> Draft:
    rng = np.random.default_rng((seed, family))
    fixed = rng.random() < 0.6
    order = int(rng.choice(ORDERS, p=SHARES))
    order = order if fixed else max(2, order)
    amplification = 10.0 ** abs(rng.normal(0.0, 0.5))
    uncertainty = 10.0 ** (rng.uniform(-10.0, -7.0) if rng.random() < 0.1 else rng.uniform(-15.0, -10.0))
    shown = rng.choice([order, order + 1, max(1, order - 1), 1], p=[0.8, 0.08, 0.07, 0.05])
    by_tolerance = rng.choice([1.0, order / (order + 1.0), rng.uniform(0.7, 1.2)], p=[0.4, 0.4, 0.2])
    duration = 10.0 ** rng.uniform(0.0, 1.3)
    return Draft(
        (seed, family), rng, "fixed" if fixed else "adaptive", order, duration, amplification,
        uncertainty, int(rng.integers(40, 121)),
        power=float(shown if fixed else by_tolerance),
        reach=rng.uniform(-1.6, -0.3) if fixed else 0.0,
        height=math.log10(amplification) + (rng.normal(-0.5, 0.4) if fixed else rng.normal(0.7, 0.9)),
        scatter=10.0 ** rng.uniform(-2.5, -0.8) if fixed else rng.uniform(0.05, 0.35),
        turning=10.0 ** rng.uniform(-2.5, -0.7) if fixed else rng.uniform(0.2, 1.0),
        width=rng.uniform(0.3, 1.0) if fixed else rng.uniform(0.1, 0.5),
        first_steps=duration * 10.0 ** rng.uniform(0.0, 1.0), embedded=order,
    )  # fmt: skip
