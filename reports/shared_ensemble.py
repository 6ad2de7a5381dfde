"""An ensemble whose runs are shared among processes, on this machine or a cluster's."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from cross_checks.isolation.parent import Caller, Isolated
from cross_checks.isolation.workers import each
from mbs_ref import Settings
from mbs_ref.cores.system import Poses
from mbs_ref.simulate.many.ensemble import Design, Ensemble, Variants, run_ensemble

PORTIONS = 4  # parts for each process: their runs take unlike times
BY_RUN = ("reached", "errors", "corrections")  # arrays of an ensemble, besides the samples
NAMES = ("statuses", "messages", "methods")


@dataclass(frozen=True)
class Part(Design):
    """Some of a design's runs, with the same values as in the whole."""

    first: int = 0
    stop: int = 0

    @property
    def n_runs(self) -> int:
        return self.stop - self.first

    @cached_property
    def values(self) -> np.ndarray:
        return Design(self.laws, self.count, self.seed).values[self.first : self.stop]


def shared_ensemble(
    variants: Variants, design: Design, settings: Settings, call: Isolated, report: Callable[[int, int], None]
) -> Ensemble:
    """Return the ensemble; after Ctrl-C the runs of the first parts that are complete."""
    edges = np.linspace(0, design.n_runs, min(design.n_runs, PORTIONS * call.processors) + 1).astype(int).tolist()
    parts = [Part(design.laws, design.count, design.seed, *ends) for ends in pairwise(edges)]
    began, result, marks = time.perf_counter(), {}, []
    try:
        for part, built in each(parts, partial(_made, variants, settings), call=call):
            result[part.first] = built
            marks.append((sum(len(one.statuses) for one in result.values()), time.perf_counter() - began))
            report(marks[-1][0], design.n_runs)
    except KeyboardInterrupt:
        pass
    whole = [part for k, part in enumerate(parts) if all(one.first in result for one in parts[: k + 1])]
    if not whole:
        raise KeyboardInterrupt
    return joined(design, [result[part.first] for part in whole], tuple(marks))


def _made(variants: Variants, settings: Settings, call: Caller, part: Part) -> Ensemble:
    return call(run_ensemble, variants, part, settings, 1)


def joined(design: Design, parts: Sequence[Ensemble], marks: tuple[tuple[int, float], ...]) -> Ensemble:
    """Return the runs of consecutive parts as one ensemble."""
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in BY_RUN}
    words = {name: tuple(word for part in parts for word in getattr(part, name)) for name in NAMES}
    samples = Poses(*(np.concatenate(all_of) for all_of in zip(*(part.samples for part in parts), strict=True)))
    how = tuple(dict.fromkeys(word for part in parts for word in part.how))
    return replace(parts[0], design=design, samples=samples, how=how, marks=marks, **arrays, **words)
