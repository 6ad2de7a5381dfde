"""A file's motion as it is understood so far, and what it is held against."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cross_checks.judge.measure import error_of
from cross_checks.metrics.metric import Judged
from cross_checks.trajectory_files.column_map import ColumnMap
from cross_checks.trajectory_files.columns import Columns
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory

TruthAt = Callable[[np.ndarray], Truth | NoTruth]
NONE = 1e-9  # rad, or of the scene's length: a smaller turn or offset is none


@dataclass(frozen=True)
class Case:
    """What a mistake is looked for in."""

    scene: Scene
    columns: Columns
    stated: ColumnMap
    path: Trajectory
    truth: Truth
    truth_at: TruthAt  # at other times (n_t,), s

    @property
    def error(self) -> float:
        """Of the scene; infinite where it is not finite."""
        error, _ = error_of(Judged(self.scene, self.path, self.truth))
        return np.inf if error is None else error.value

    @property
    def planar(self) -> bool:
        return self.scene.dimension == 2

    @property
    def length(self) -> float:
        """The scene's, m."""
        return scales_of(self.scene).length

    @property
    def comparable_turns(self) -> bool:
        """Whether both sides count orientations alike; a truth of particles has none."""
        return self.truth.orientation.ndim == self.path.orientation.ndim


def vector(values: np.ndarray) -> str:
    """Return a vector for a sentence; what is roundoff beside the largest component is 0."""
    largest = np.max(np.abs(values))
    return f"({', '.join(f'{0.0 if abs(v) < 5e-4 * largest else v:.4g}' for v in values)})"
