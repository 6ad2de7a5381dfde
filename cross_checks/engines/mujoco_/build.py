"""A scene as a MuJoCo model: every body's frame is its joint's, along the world's axes at t = 0."""

import mujoco
import numpy as np

from cross_checks.engine import Plan
from cross_checks.engines.mujoco_.contact import add_contact
from cross_checks.engines.mujoco_.loads import LOADS, add_tendon
from cross_checks.engines.mujoco_.run import pin_options, solref_of
from cross_checks.linkage.links import Closure, Link, Linkage
from cross_checks.linkage.tree import FIXED
from mbs_ref.scene.euler_parameters import from_matrix

JOINTS = {
    "free": mujoco.mjtJoint.mjJNT_FREE, "ball": mujoco.mjtJoint.mjJNT_BALL, "slide": mujoco.mjtJoint.mjJNT_SLIDE,
    "turn": mujoco.mjtJoint.mjJNT_HINGE,
}  # fmt: skip
LEAST_MOMENT = 2.0 * mujoco.mjMINVAL  # kg m^2, of a particle on a rod: MuJoCo takes nothing smaller


def specify_links(linkage: Linkage, plan: Plan) -> tuple[mujoco.MjSpec, dict]:
    """Return a specification of all links and closures, and the frame of each body in it."""
    spec = mujoco.MjSpec()
    pin_options(spec, plan, linkage.scene)
    frames = {FIXED: spec.worldbody}
    for link in linkage.links:
        frames[link.body] = _add_body(frames[link.parent], linkage, link)
    for closure in linkage.closures:
        _add_closure(spec, frames, linkage, closure, solref_of(plan))
    return spec, frames


def add_loads(spec, frames, linkage: Linkage, shared: bool) -> None:
    """Add the loads; `shared` forces come from their callback with the weight."""
    if shared:
        spec.option.gravity = (0.0, 0.0, 0.0)
        return
    for load in linkage.scene.loads:
        LOADS[type(load)](spec, frames, linkage, load)


def compile_links(linkage: Linkage, plan: Plan, shared: bool) -> mujoco.MjModel:
    """Return the model; with `shared` forces, their callback applies all loads, contacts and the weight."""
    spec, frames = specify_links(linkage, plan)
    add_loads(spec, frames, linkage, shared)
    for contact in () if shared else linkage.scene.contacts:
        add_contact(spec, frames, linkage, contact)
    return spec.compile()


def _add_body(parent: mujoco.MjsBody, linkage: Linkage, link: Link) -> mujoco.MjsBody:
    frame = parent.add_body(name=link.name, pos=link.origin - linkage.origin(link.parent))
    moments, axes = np.linalg.eigh(link.inertia)
    moments = np.maximum(moments, LEAST_MOMENT)
    moments[2] = min(moments[2], moments[0] + moments[1])  # a plate's roundoff would be refused
    frame.explicitinertial, frame.mass, frame.inertia = True, link.mass, moments
    frame.ipos, frame.iquat = link.centre, from_matrix(np.linalg.det(axes) * axes)
    for k, (kind, axis) in enumerate(link.freedoms):
        frame.add_joint(name=f"{link.name}/{k}", type=JOINTS[kind], **({"axis": axis} if axis.any() else {}))
    return frame


def _add_closure(spec, frames, linkage: Linkage, closure: Closure, solref: tuple[float, float]) -> None:
    """Tie two bodies by soft constraints."""
    names = {FIXED: "world"} | {link.body: link.name for link in linkage.links}
    if closure.kind == "rod":
        ends = ((closure.a, closure.point_a), (closure.b, closure.point_b))
        tendon = add_tendon(spec, frames, closure.name, [(body, point - linkage.origin(body)) for body, point in ends])
        rows = [spec.add_equality(name=closure.name, type=mujoco.mjtEq.mjEQ_TENDON, name1=tendon.name)]
        rows[0].data[0] = closure.length - float(np.linalg.norm(closure.point_b - closure.point_a))
    else:
        weld = closure.kind == "weld"
        ends = (closure.b, closure.a) if weld else (closure.a, closure.b)  # the anchor is in body 2 of a weld, else 1
        ends = [names[end] for end in ends]
        kind = mujoco.mjtEq.mjEQ_WELD if weld else mujoco.mjtEq.mjEQ_CONNECT
        rows = []
        for k, point in enumerate(closure.shared_points):
            row = spec.add_equality(name=f"{closure.name}/{k}", type=kind, objtype=mujoco.mjtObj.mjOBJ_BODY)
            row.name1, row.name2 = ends
            row.data[0:3] = point - linkage.origin(closure.a)
            if weld:
                row.data[10] = 1.0  # m/rad, torque scale
            rows.append(row)
    for row in rows:
        row.active, row.solref = True, solref
