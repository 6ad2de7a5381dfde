"""A planar tree in relative coordinates, by the articulated-body algorithm in linear time.

State y = [q, u]: x, y, theta of a free body, an angle a revolute, a length a prismatic joint, and their rates.
Leaf to root, a body that answers a push f by I is condensed into its parent: with a = X a_p + S q'' + c,
    D = S^T I S,  I_p += X^T (I - I S D^-1 S^T I) X,  f_p += X^T (f - I c - I S D^-1 S^T (f - I c))
Root to leaf, q'' = D^-1 S^T (f - I c - I X a_p). Source: Featherstone, Rigid Body Dynamics Algorithms (2008), sec. 7.3,
here in world axes about the centres of mass, as the redundant cores have them.
"""

from mbs_ref.kernels.algebra.dense import ldl3_at, ldl3_solve
from mbs_ref.kernels.algebra.lanes import cos_sin, either
from mbs_ref.kernels.border import questions as ask
from mbs_ref.kernels.jit import bare, inlined, jit
from mbs_ref.kernels.planar import dynamics
from mbs_ref.kernels.planar.marks import minus, pair, perpendicular, plus, rotated, times
from mbs_ref.kernels.relative.model import FREE, HELD, PRISMATIC, REVOLUTE

ORIGIN = (0.0, 0.0)


_redundant_model = either(
    "_redundant_model(model)", jit(lambda model: dynamics.PlanarModel(model.redundant.address[0])),
    jit(lambda model: dynamics.PlanarModelInLanes(model.redundant.address[0])),
)  # fmt: skip
_redundant_work = either(
    "_redundant_work(model)", jit(lambda model: dynamics.PlanarWork(model.redundant.address[1])),
    jit(lambda model: dynamics.PlanarWorkInLanes(model.redundant.address[1])),
)  # fmt: skip


@jit
def place_planar(model, work, y):
    """Write every body's pose and motion to the redundant system's scratch, and the joints' links."""
    joints, links, kin = model.joints, work.links, _redundant_work(model).kinematics
    for i in range(joints.kind.shape[0]):
        if joints.kind[i] == FREE:
            _put_free(joints, links, kin, y, i)
        else:
            _put_joined(joints, links, kin, y, i)
        for c in range(3):
            kin.motion[i, c] = links.velocity[i, c]


@inlined
def _put_pose(kin, i, place, angle):
    kin.pose[i, 0], kin.pose[i, 1] = place
    kin.pose[i, 2], kin.pose[i, 3] = cos_sin(angle)
    kin.motion[i, 3] = angle


@inlined
def _put_free(joints, links, kin, y, i):
    q, v = joints.q[i], joints.v[i]
    turns = joints.freedoms[i] == 3
    _put_pose(kin, i, (y[q], y[q + 1]), y[q + 2] if turns else 0.0)
    links.velocity[i, 0], links.velocity[i, 1] = y[v], y[v + 1]
    links.velocity[i, 2] = y[v + 2] if turns else 0.0


@inlined
def _put_joined(joints, links, kin, y, i):
    kind, parent, q, v = joints.kind[i], joints.parent[i], joints.q[i], joints.v[i]
    of_parent, own, free, bias = links.velocity[parent], links.velocity[i], links.freedom[i], links.bias[i]
    c, s, spin = kin.pose[parent, 2], kin.pose[parent, 3], of_parent[2]
    angle, speed, rate = kin.motion[parent, 3] + joints.offset[i, 0], 0.0, 0.0
    if kind == REVOLUTE:
        angle, rate = angle + y[q], y[v]
    reach = rotated(c, s, joints.arm_of_parent[i])
    _put_pose(kin, i, ORIGIN, 0.0 if kind == HELD else angle)
    arm = rotated(kin.pose[i, 2], kin.pose[i, 3], joints.arm[i])
    away = minus(ORIGIN, arm)  # from the joint's point to the centre of mass
    slide = ORIGIN
    if kind == PRISMATIC:
        slide, speed = rotated(c, s, joints.axis[i]), y[v]
        reach = plus(reach, times(y[q], slide))
        free[0], free[1], free[2] = slide[0], slide[1], 0.0
    elif kind == REVOLUTE:
        free[0], free[1], free[2] = -away[1], away[0], 1.0
    apart, turning = plus(reach, away), spin + rate
    inward = plus(times(spin * spin, reach), times(turning * turning, away))
    surplus = minus(times(2.0 * spin * speed, perpendicular(slide)), inward)
    links.apart[i, 0], links.apart[i, 1] = apart
    bias[0], bias[1] = surplus
    kin.pose[i, 0], kin.pose[i, 1] = plus(pair(kin.pose[parent], 0), apart)
    own[0] = of_parent[0] - spin * apart[1] - rate * away[1] + speed * slide[0]
    own[1] = of_parent[1] + spin * apart[0] + rate * away[0] + speed * slide[1]
    own[2] = links.turns[i] * turning


@jit
def relative_planar_expand(model, work, y):
    place_planar(model, work, y)
    full, bodies, kin = work.full, _redundant_model(model).bodies, _redundant_work(model).kinematics
    n = bodies.mass.shape[0]
    for i in range(n):
        k = 3 * bodies.scene_index[i]
        full.state[k], full.state[k + 1], full.state[k + 2] = kin.pose[i, 0], kin.pose[i, 1], kin.motion[i, 3]
        for c in range(3):
            full.state[3 * n + k + c] = kin.motion[i, c]


@inlined
def _condense(joints, links, rec, i):
    """Add I' and f' of a body to its parent's (see above); i's own block is left with what its joint needs."""
    parent, a, f, free = joints.parent[i], rec.articulated[i], rec.force[i], links.freedom[i]
    c0, c1 = links.bias[i, 0], links.bias[i, 1]
    a00, a10, a11, a20, a21, a22 = a[0, 0], a[1, 0], a[1, 1], a[2, 0], a[2, 1], a[2, 2]
    f0, f1, f2 = f[0] - a00 * c0 - a10 * c1, f[1] - a10 * c0 - a11 * c1, f[2] - a20 * c0 - a21 * c1
    if joints.freedoms[i] == 1:
        s0, s1, s2 = free[0], free[1], free[2]
        u0, u1 = a00 * s0 + a10 * s1 + a20 * s2, a10 * s0 + a11 * s1 + a21 * s2
        u2 = a20 * s0 + a21 * s1 + a22 * s2
        inverse, load = 1.0 / (s0 * u0 + s1 * u1 + s2 * u2), s0 * f0 + s1 * f1 + s2 * f2
        rec.answer[i, 0, 0], rec.answer[i, 0, 1], rec.answer[i, 0, 2] = u0, u1, u2
        rec.pivot[i, 0], rec.drive[i, 0] = inverse, load
        w0, w1, w2, load = inverse * u0, inverse * u1, inverse * u2, inverse * load
        a00, a10, a11 = a00 - u0 * w0, a10 - u1 * w0, a11 - u1 * w1
        a20, a21, a22 = a20 - u2 * w0, a21 - u2 * w1, a22 - u2 * w2
        f0, f1, f2 = f0 - load * u0, f1 - load * u1, f2 - load * u2
    if parent == joints.kind.shape[0]:
        return
    d0, d1, turns, onto, push = links.apart[i, 0], links.apart[i, 1], links.turns[i], rec.articulated[parent], rec.force
    p0, p1 = d0 * a10 - d1 * a00 + turns * a20, d0 * a11 - d1 * a10 + turns * a21
    onto[0, 0] += a00
    onto[1, 0] += a10
    onto[1, 1] += a11
    onto[2, 0] += p0
    onto[2, 1] += p1
    onto[2, 2] += d0 * p1 - d1 * p0 + turns * (d0 * a21 - d1 * a20 + turns * a22)
    push[parent, 0] += f0
    push[parent, 1] += f1
    push[parent, 2] += d0 * f1 - d1 * f0 + turns * f2


@inlined
def _release(joints, links, rec, i):
    """Solve for q'' of a body's joint and its acceleration, its parent's being known."""
    own, of_parent, a, f = rec.acceleration[i], rec.acceleration[joints.parent[i]], rec.articulated[i], rec.force[i]
    if joints.kind[i] == FREE:
        own[0], own[1], own[2] = ldl3_solve(ldl3_at(a, 0), f)
        rec.drive[i, 0], rec.drive[i, 1], rec.drive[i, 2] = own[0], own[1], own[2]
        return
    own[0] = of_parent[0] - of_parent[2] * links.apart[i, 1]
    own[1] = of_parent[1] + of_parent[2] * links.apart[i, 0]
    own[2] = links.turns[i] * of_parent[2]
    if joints.freedoms[i] == 1:
        u, free = rec.answer[i, 0], links.freedom[i]
        drive = rec.pivot[i, 0] * (rec.drive[i, 0] - u[0] * own[0] - u[1] * own[1] - u[2] * own[2])
        rec.drive[i, 0] = drive
        own[0] += drive * free[0]
        own[1] += drive * free[1]
        own[2] += drive * free[2]
    own[0] += links.bias[i, 0]
    own[1] += links.bias[i, 1]


@bare
def _load_blocks(bodies, kin, rec):
    for i in range(bodies.mass.shape[0]):
        a, mass = rec.articulated[i], bodies.mass[i]
        a[0, 0], a[1, 0], a[1, 1], a[2, 0], a[2, 1], a[2, 2] = mass, 0.0, mass, 0.0, 0.0, bodies.inertia[i, 0]
        for c in range(3):
            rec.force[i, c] = kin.force[i, c]


@jit
def relative_planar_derivative(model, work, t, y, dy):
    """Write dy/dt = [u, u']."""
    place_planar(model, work, y)
    ask.apply_loads(_redundant_model(model), _redundant_work(model), t)
    joints, links, rec = model.joints, work.links, work.recursion
    n = joints.kind.shape[0]
    _load_blocks(_redundant_model(model).bodies, _redundant_work(model).kinematics, rec)
    for i in range(n - 1, -1, -1):
        if joints.kind[i] != FREE:
            _condense(joints, links, rec, i)
    for i in range(n):
        _release(joints, links, rec, i)
        for k in range(joints.freedoms[i]):
            dy[joints.q[i] + k] = y[joints.v[i] + k]
            dy[joints.v[i] + k] = rec.drive[i, k]


# Write the rates of lengths and angles at `rate`.
relative_planar_position_rate = relative_planar_rate_from = dynamics.planar_position_rate


@jit
def relative_planar_take_velocities(model, work, y):
    joints, links, full, bodies = model.joints, work.links, work.full, _redundant_model(model).bodies
    n = bodies.mass.shape[0]
    for i in range(n):
        k, parent, v, own = 3 * (n + bodies.scene_index[i]), joints.parent[i], joints.v[i], links.velocity[i]
        for c in range(3):
            own[c] = full.state[k + c]
        for c in range(joints.freedoms[i]):
            y[v + c] = own[c]
        if joints.kind[i] == REVOLUTE:
            y[v] = own[2] - links.velocity[parent, 2]
        elif joints.kind[i] == PRISMATIC:
            spin, apart, free = links.velocity[parent, 2], links.apart[i], links.freedom[i]
            y[v] = free[0] * (own[0] - links.velocity[parent, 0] + spin * apart[1])
            y[v] += free[1] * (own[1] - links.velocity[parent, 1] - spin * apart[0])
