"""Runs that cannot be: a trajectory without samples stands for each, and says why."""

from __future__ import annotations

from collections.abc import Callable

from mbs_ref.run.many import stopped
from mbs_ref.scene import Scene
from mbs_ref.self_checks.consistent_start import InconsistentScene
from mbs_ref.self_checks.soundness import UnsoundScene
from mbs_ref.trajectory import Status, Trajectory


def or_stopped[T](scene: Scene, make: Callable[[], T], refusal: type[ValueError] = UnsoundScene) -> T | Trajectory:
    """Return what is made, or a trajectory that ended before it began.

    It is `inconsistent` where the start breaks a constraint, and `refused` by such errors; others are raised.
    """
    try:
        return make()
    except InconsistentScene as error:
        return stopped(scene, Status.INCONSISTENT, str(error))
    except refusal as error:
        return stopped(scene, Status.REFUSED, str(error))
