"""What is to be said beside an ensemble's figures: how runs ended, what was repaired, what its spread is worth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from mbs_ref.scene import PointMass
from mbs_ref.simulate.ensemble.runs import Ensemble
from mbs_ref.simulate.ensemble.statistics import SHOWN, Coordinate, Statistics, integration_error, not_shown
from mbs_ref.trajectory import Status

MOST_NAMED = 6  # coordinates whose spread is not shown


def account(ensemble: Ensemble, found: list[Statistics | None]) -> list[str]:
    """Return the sentences, the most important ones last."""
    return [*_made(ensemble), *_ends(ensemble), *_projected(ensemble), *_worth(ensemble, found)]


def _made(ensemble: Ensemble) -> Iterator[str]:
    yield ensemble.design.sentence()
    methods = Counter(name for name in ensemble.methods if name).most_common()
    told = ", ".join(name if len(methods) == 1 else f"{name} ({count} runs)" for name, count in methods)
    yield "; ".join(filter(None, (told, *ensemble.how)))


def _ends(ensemble: Ensemble) -> Iterator[str]:
    """Say how runs ended, and of those that failed what the first of a kind says."""
    asked, made = ensemble.design.n_runs, len(ensemble.statuses)
    if not ensemble.is_complete:
        yield f"interrupted after {made} of {asked} runs"
    yield f"{made} runs: " + ", ".join(f"{count} {status}" for status, count in ensemble.counts.items())
    firsts = dict(zip(reversed(ensemble.statuses), reversed(ensemble.messages), strict=True))
    yield from (f"{status}: {message}" for status, message in firsts.items() if status is not Status.SUCCESS)
    ended = ensemble.reached[[status is Status.STOP_EVENT for status in ensemble.statuses]]
    if len(ended):
        spread = f", standard deviation {ended.std(ddof=1):.4g} s" if len(ended) > 1 else ""
        yield f"an event ended {len(ended)} runs, at {ended.mean():.6g} s on average{spread}, " + (
            f"from {ended.min():.6g} to {ended.max():.6g} s"
        )
    left_out = made - int(ensemble.ended_well.sum())
    if left_out:
        yield f"{left_out} of {made} runs are left out of all figures, which are of the others alone"


def _projected(ensemble: Ensemble) -> Iterator[str]:
    poses, rates = ensemble.corrections.max(axis=0, initial=0.0)
    tolerance = ensemble.settings.initial_tolerance
    count = int(np.sum(ensemble.corrections.max(axis=1) > tolerance))
    hint = "" if poses > tolerance else "; --keep keeps a velocity and lets the others follow"
    if count:
        yield (
            f"the starts of {count} runs were projected, by up to {poses:.3g} m or rad and {rates:.3g} m/s or rad/s: "
            f"what is varied there is not what was asked for{hint}"
        )


def _worth(ensemble: Ensemble, found: list[Statistics | None]) -> Iterator[str]:
    """Say by how much runs may be off, and which spreads are therefore not seen."""
    if not ensemble.ended_well.any():
        return
    metres, radians = integration_error(ensemble)[-1]
    if np.isnan(metres):
        yield "no run's integration error was estimated: whether the spread is more than that is not known"
        return
    if np.isinf(metres):
        yield "estimated integration error: at the end of some runs no digit is vouched for; ask for less --t-end"
        return
    angle = f"{radians:.3g} rad" if np.isfinite(radians) else "any number of turns"
    turned = "" if all(isinstance(body, PointMass) for body in ensemble.scene.bodies) else f" and {angle}"
    yield f"estimated integration error of the runs: at most {metres:.3g} m{turned}"
    hidden = not_shown(ensemble, found)
    if hidden:
        yield (
            f"the spread of {_listed(hidden)} is not shown by these runs: their integration error may be more than "
            f"{SHOWN:g} of it; take a smaller --rtol or --step"
        )


def _listed(hidden: list[Coordinate]) -> str:
    names = [f"{one.body}.{one.name}" for one in hidden[:MOST_NAMED]]
    return ", ".join(names) + (f" and {len(hidden) - MOST_NAMED} more" if len(hidden) > MOST_NAMED else "")
