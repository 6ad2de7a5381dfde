"""A choice put to the test: the winner against the runner-up in interleaved runs, and the setting run afresh."""

from dataclasses import replace

import numpy as np

from cross_checks import engines
from cross_checks.isolation.parent import Caller, Lost, direct
from cross_checks.judge import ladder
from cross_checks.judge.cell import truth_of
from cross_checks.judge.one_run import evaluate, without_run
from cross_checks.judge.runs import Runs
from cross_checks.prices.pick import Choice, setting
from cross_checks.prices.timing import Comparison, Pace, compare, sample
from cross_checks.records.record import Record
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Settings

CLOSE = 1.5  # a margin below this may be noise: the two are timed against each other

OUTPUTS = 11  # times at which an engine is looked at as it comes

WORDS = {
    Pace.SLOWER: "Confirmed by",
    Pace.FASTER: "Overturned by",
    Pace.SAME: "A tie in",
    Pace.INCONCLUSIVE: "Not settled by",
}


def duel(scene: Scene, choice: Choice, call: Caller = direct, seed: int = 0) -> Comparison:
    """Time the runner-up against the best in interleaved pairs; the ratio is the runner-up's time over the best's.

    ValueError where there is no runner-up.
    """
    if choice.best is None or choice.runner_up is None:
        raise ValueError("there is no runner-up to time the best against")
    first, second = ((r.engine, Settings(**r.settings)) for r in (choice.best, choice.runner_up))
    return compare(lambda: call(sample, scene, *first), lambda: call(sample, scene, *second), seed)


def settled(choice: Choice, comparison: Comparison) -> Choice:
    """Return the choice as the duel leaves it: the two change places where the runner-up is the faster."""
    assert choice.best is not None
    assert choice.runner_up is not None
    first, second, ratio = choice.best, choice.runner_up, comparison.ratio
    if comparison.pace is Pace.FASTER:
        first, second, ratio = second, first, 1.0 / ratio
    interval = f"{comparison.ratio:.3g} [{comparison.low:.3g}, {comparison.high:.3g}]"
    blocks = f"{WORDS[comparison.pace]} {comparison.blocks} interleaved blocks"
    text = f"{blocks}: {setting(choice.runner_up)} takes {interval} times as long as {setting(choice.best)}."
    sentence = f"{choice.sentence} {text}"
    return replace(choice, best=first, runner_up=second, margin=ratio, sentence=sentence)


def as_shipped(runs: Runs, scene: Scene, engine: str) -> Record | None:
    """Return the run of an engine as it comes, held against the scene's truth at its own steps.

    None where the engine is not installed or does not say how it comes.
    """
    try:
        given = engines.get(engine).as_shipped
    except engines.EngineMissing:
        return None
    if given is None or given.step is None:
        return None
    whole = max(1, int(scene.duration / given.step))
    own = replace(runs, times=np.unique(np.linspace(0.0, whole, min(OUTPUTS, whole + 1)).round()) * given.step)
    return own.judged(scene, engine, given, truth_of(own, scene))


def afresh(scene: Scene, record: Record, truth: Truth | NoTruth, call: Caller = direct) -> Record:
    """Run a record's setting again, whatever the store holds, and hold it against the truth."""
    settings = Settings(**record.settings)
    try:
        return call(_judged, scene, record.engine, settings, truth)
    except Lost as lost:
        return without_run(scene, record.engine, settings, lost.status, str(lost))


def _judged(scene: Scene, engine: str, settings: Settings, truth: Truth | NoTruth) -> Record:
    return evaluate(scene, engine, settings, ladder.grid(scene), truth=truth)
