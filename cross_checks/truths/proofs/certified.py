"""Whether a truth lies in a proven enclosure, to the uncertainty that it states."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cross_checks.truths.proofs.checker.model import TURNS
from cross_checks.truths.proofs.checker.proof import Proof


@dataclass(frozen=True)
class Placed:
    """How far a truth's places are from their enclosures, m."""

    distance: float  # the largest, beyond the enclosure's radius
    uncertainty: float  # as the truth states
    times: int  # that both know

    @property
    def inside(self) -> bool:
        """Whether the truth is as near as it states."""
        return self.distance <= self.uncertainty


def enclosed(proof: Proof, truth: Any) -> Placed:
    """Return how far a `Truth` at the proof's times is from what is proven: centres of mass, and angles times 1 m."""
    worst = 0.0
    for k, bodies in enumerate(proof.enclosures):
        for j, (body, own) in enumerate(zip(proof.model.scene.bodies, bodies, strict=True)):
            n = len(body.position)
            gaps = [
                x - float(right) for x, right in zip(own[:n], truth.position[k, j], strict=True) if np.isfinite(right)
            ]
            if TURNS[body.type] == 1 and np.isfinite(truth.orientation[k, j]):
                gaps.append(2 * ((own[n] + body.angle - float(truth.orientation[k, j])) / 2).sin())  # of whole turns
            worst = max(worst, math.hypot(*(float(gap.abs_lower()) for gap in gaps)))
    return Placed(worst, truth.uncertainty, len(proof.enclosures))
