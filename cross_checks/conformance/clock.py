"""Does an engine's clock report the work of its loop?"""

from collections.abc import Callable, Iterable

from cross_checks.conformance.apart import Called, called
from cross_checks.conformance.questions import Question
from cross_checks.engine import Engine
from mbs_ref import Settings

FASTEST = 5e-9  # s: no processor evaluates a right-hand side, or takes a step, in less
WORK = 0.1  # s of processor time, by which a longer run must exceed a shorter one to be compared
LONGEST = 4.0**8  # times the span: a run that is quicker still is not compared
COUNTED = 0.6  # of the additional processor time, which a clock must report: scheduling disturbs by less


def impossible_time(runs: Iterable[Called]) -> str:
    """Return a sentence where a loop's time does not fit into its call, or is shorter than any processor takes."""
    for run in runs:
        clock, counted = run.path.timing, max(run.path.steps, run.path.rhs_calls)
        total = clock.build_s + clock.first_call_s + clock.loop_s
        if not clock.loop_s > 0.0:
            return f"{run.setting}: the loop is not timed"
        # the two clocks are read apart: a tenth of a millisecond may pass between
        if total > 1.01 * run.wall_s + 1e-4:
            return f"{run.setting}: {total:.2e} s are reported of a call of {run.wall_s:.2e} s"
        if clock.loop_s < counted * FASTEST:
            work = f"{counted} steps or right-hand sides in {clock.loop_s:.2e} s"
            return f"{run.setting}: {work} are beyond any processor"
    return ""


def uncounted_work(engine: Engine, question: Question, settings: Settings) -> str:
    """Return a sentence where longer runs cost more processor time than the loop's clock reports.

    What a call costs besides its loop does not grow with the span. A collector at work may cost as much, once: the
    failure must come again. Several threads use more processor time than passes: the shorter of both is compared.
    """

    def run(factor: float) -> Called:
        return called(engine, question.scene, settings, factor * question.times)

    short, factor = run(1.0), 4.0
    long = run(factor)
    while long.path.ok and _cost(short, long) < WORK and factor < LONGEST:
        factor *= 4.0
        long = run(factor)
    return uncounted(lambda: (run(1.0), run(factor)), short, long)


def uncounted(again: Callable[[], tuple[Called, Called]], short: Called, long: Called) -> str:
    """Return a sentence where the clocks of two runs, and of the same two again, leave out work."""
    if not _leaves_out(short, long):
        return ""
    short, long = again()
    if not _leaves_out(short, long):
        return ""
    reported = long.path.timing.loop_s - short.path.timing.loop_s
    return f"a longer run costs {_cost(short, long):.2e} s more, of which the loop's clock reports {reported:.2e} s"


def _leaves_out(short: Called, long: Called) -> bool:
    reported, cost = long.path.timing.loop_s - short.path.timing.loop_s, _cost(short, long)
    return long.path.ok and cost > WORK and reported < COUNTED * cost


def _cost(short: Called, long: Called) -> float:
    return min(long.cpu_s - short.cpu_s, long.wall_s - short.wall_s)
