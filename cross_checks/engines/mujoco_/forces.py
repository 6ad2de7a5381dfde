"""Loads and contacts that MuJoCo's own elements cannot be, applied by the shared force code at every stage."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import mujoco

from cross_checks.engine import Refusal
from cross_checks.engines.mujoco_.contact import contact_refusals
from cross_checks.engines.mujoco_.loads import load_refusals
from cross_checks.engines.mujoco_.observe import Observer
from cross_checks.linkage.forces import Applied
from cross_checks.linkage.forces import contact_refusals as located_refusals
from cross_checks.linkage.links import Linkage

type Callback = Callable[[mujoco.MjModel, mujoco.MjData], None]


def own_refusals(linkage: Linkage) -> list[Refusal]:
    """Return why MuJoCo's own elements cannot stand for all loads and contacts."""
    reasons = load_refusals(linkage) + contact_refusals(linkage.scene)
    return [Refusal(reason, permanent=False) for reason in reasons]


def takes_shared_forces(linkage: Linkage) -> bool:
    """Return whether a tree needs the shared force code; a loop's soft constraints would act against it."""
    return bool(not linkage.closures and own_refusals(linkage))


def force_refusals(linkage: Linkage) -> list[Refusal]:
    """Return why neither MuJoCo nor the shared force code can stand for the loads and contacts."""
    own, located = own_refusals(linkage), located_refusals(linkage.scene)
    return own + located if own and (linkage.closures or located) else []


@contextmanager
def passive(act: Callback | None) -> Iterator[None]:
    """Let MuJoCo call `act` whenever it asks for passive forces: at every stage of every step."""
    mujoco.set_mjcb_passive(act)
    try:
        yield
    finally:
        mujoco.set_mjcb_passive(None)


def shared_forces(model: mujoco.MjModel, linkage: Linkage) -> Callback:
    """Return what sets the forces on all bodies."""
    applied, observer = Applied(linkage), Observer(model, linkage)

    def act(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        data.xfrc_applied[observer.index] = applied.wrenches(data.time, observer.motion(data))

    return act
