"""A script that runs in Pinocchio alone, under the Runge-Kutta methods that drive it."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from cross_checks.writers import Form, Job, job_of, script, turns_of
from mbs_ref import Settings
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.euler_parameters import rotation_matrices


def write_pinocchio(scene: Scene, settings: Settings) -> str:
    """Return the script: Pinocchio's model joint by joint, its constraints and the start as tables.

    Raises NotWritable where the adapter's force code acts.
    """
    job = job_of(scene, settings, "pinocchio")  # raises EngineMissing before the adapter's modules are imported
    from cross_checks.engines.pinocchio_ import PROXIMAL
    from cross_checks.engines.pinocchio_.build import joints_of

    mechanism = job.built.mechanism
    needs = "pinocchio (pin), numpy" + ("" if job.plan.counts else " and scipy")
    return script(
        job, needs, joints=list(joints_of(mechanism.model)), constraints=list(_constraints(mechanism)),
        gravity=mechanism.model.gravity.linear, start=job.built.start, placements=list(_placements(job)),
        turns=turns_of(scene), proximal=PROXIMAL,
    )  # fmt: skip


def _constraints(mechanism: Any) -> Iterator[tuple]:
    """Yield kind, both joints with the places in them, and the gains (1/s^2, 1/s)."""
    for contact in mechanism.contacts:
        one, two, gains = contact.joint1_placement, contact.joint2_placement, contact.m_baumgarte_parameters
        ends = contact.joint1_id, one.rotation, one.translation, contact.joint2_id, two.rotation, two.translation
        yield (str(contact.type).rpartition(".")[2], *ends, float(gains.Kp), float(gains.Kd))


def _placements(job: Job) -> Iterator[tuple]:
    """Yield the joint that carries each body, the body's place in it, and whether it has an orientation."""
    mechanism = job.built.mechanism
    for k, body in enumerate(job.scene.bodies):
        turn = rotation_matrices(np.array(body.orientation)) if isinstance(body, SpatialBody) else np.eye(3)
        yield int(mechanism.joint[k]), turn, mechanism.centre[k], isinstance(body, SpatialBody)


FORMS = (Form("pinocchio", ".py", "a script that runs in Pinocchio alone", write_pinocchio),)
