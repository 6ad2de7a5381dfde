"""A script that runs in Pinocchio alone, under the Runge-Kutta methods that drive it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from cross_checks.engines import get
from cross_checks.engines.writers.carried import forces_text
from cross_checks.engines.writers.form import Form, Job, job_of, refuse_own
from cross_checks.engines.writers.script import script, source
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings


def write_pinocchio(scene: Scene, settings: Settings) -> str:
    """Return the script: Pinocchio's model joint by joint, and the adapter's own right-hand side, loads and step."""
    get("pinocchio")  # raises EngineMissing before the adapter's own modules are imported
    from cross_checks.engines.pinocchio_ import dynamics, loop
    from cross_checks.engines.pinocchio_.build import Mechanism, _places

    job = job_of(scene, settings, "pinocchio")
    mechanism = job.built.mechanism
    refuse_own(scene, "pinocchio")
    turning = [Mechanism.number_coordinates, Mechanism.configured, Mechanism.rate]
    needs = "pinocchio (pin), numpy" + ("" if job.plan.counts else " and scipy")
    return script(
        job, needs, joints=list(_joints(mechanism.model)), constraints=list(_constraints(mechanism)),
        gravity=mechanism.model.gravity.linear, start=job.built.start, placements=list(_placements(job)),
        proximal=dynamics.PROXIMAL,
        dynamics=source(dynamics.right_hand_side), step=source(loop._rk4_step if job.plan.counts else loop._land),
        forces="" if mechanism.applied is None else forces_text(mechanism.applied), breaks=list(_breaks(job)),
        turning=source(*turning), places=source(_places),
    )  # fmt: skip


def _breaks(job: Job) -> list[float]:
    """Return where the integrator restarts (s), with the start and the end."""
    end = float(job.plan.times[-1])
    return np.union1d([t for t in job.built.breakpoints if 0.0 < t < end], [0.0, end]).tolist()


def _place(placement: Any) -> tuple[Any, Any]:
    """Return the rows of the rotation matrix, and the translation (m)."""
    return np.array(placement.rotation).tolist(), np.array(placement.translation).tolist()


def _joints(model: Any) -> Iterator[tuple]:
    """Yield parent, name, kind, axis, placement in the parent, mass, centre and inertia about it."""
    for i in range(1, model.njoints):
        joint, inertia = model.joints[i].extract(), model.inertias[i]
        axis = np.array(getattr(joint, "axis", ())).tolist()
        body = (inertia.mass, np.array(inertia.lever).tolist(), np.array(inertia.inertia).tolist())
        yield (int(model.parents[i]), model.names[i], joint.shortname(), axis, *_place(model.jointPlacements[i]), *body)


def _constraints(mechanism: Any) -> Iterator[tuple]:
    """Yield kind, both joints with the places in them, and the gains (1/s^2, 1/s)."""
    for contact in mechanism.contacts:
        one = (contact.joint1_id, *_place(contact.joint1_placement))
        two = (contact.joint2_id, *_place(contact.joint2_placement))
        gains = contact.m_baumgarte_parameters
        yield (str(contact.type).rpartition(".")[2], *one, *two, float(gains.Kp), float(gains.Kd))


def _placements(job: Job) -> Iterator[tuple]:
    """Yield the joint that carries each body, and the body's centre of mass in it (m)."""
    mechanism = job.built.mechanism
    for k in range(len(job.scene.bodies)):
        yield int(mechanism.joint[k]), mechanism.centre[k].tolist()


FORM = Form("pinocchio", ".py", "a script that runs in Pinocchio alone", write_pinocchio)
