"""Applied forces in the plane and in space: gravity, forces, springs, contacts, a core's own loads and a user's.

Springs that only pull have events: where they go slack, or their damper would push. Open is slack; closed pulls; lifted
is stretched, but its damper outweighs the spring and it gives nothing; limited pulls by its limit.
"""

import numpy as np

from mbs_ref.kernels.algebra.lanes import WIDTH, add_lane, either, lane_of, vanishes
from mbs_ref.kernels.border.calls import call_user
from mbs_ref.kernels.border.handles import alone
from mbs_ref.kernels.border.questions import apply_contacts, apply_further_loads, apply_given_loads, apply_granules
from mbs_ref.kernels.contact import laws as law
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rigid import geometry as core
from mbs_ref.kernels.rigid.contact_forces import norm
from mbs_ref.kernels.rigid.marks import exchange, rate_seen, separation, speed_between
from mbs_ref.kernels.rigid.model import CONTROL_MODE_TIME
from mbs_ref.kernels.rows import clear
from mbs_ref.kernels.signals import evaluate

ALL, TWO_SIDED, ONE_SIDED = range(3)  # springs: those that only pull are one-sided


@bare
def _apply_forces(model, work, t):
    load, signals, mode_time = model.forces, model.signals, model.world.control[CONTROL_MODE_TIME]
    scale = 0.0
    for k in range(load.body.shape[0]):
        if k == 0 or load.signal[k] != load.signal[k - 1]:
            scale, _, _ = evaluate(signals, load.signal[k], t, mode_time)
        body, force = load.body[k], core.times(work, scale, load.force[k])
        if load.follows[k] == 1:
            force = core.turned(work, body, force)
        core.push(work, body, core.turned(work, body, load.point[k]), force)
        core.apply_torque(model, work, k, scale)


@jit
def _apply_user_force(model, work, t):
    """Call the user's law in scene order; it adds forces and torques about the centres of mass."""
    bodies, kin = model.bodies, work.kinematics
    n = bodies.mass.shape[0]
    for i in range(n):
        core.put_state(work, i, bodies.scene_index[i])
        for c in range(kin.user.shape[2]):
            kin.user[2, i, c] = 0.0
    call_user(model.world.user_force[0], t, kin.user.ctypes.data)
    for i in range(n):
        for c in range(len(core.block(model))):
            kin.force[i, c] += kin.user[2, bodies.scene_index[i], c]


@jit
def rigid_apply_loads(model, work, t):
    core.apply_gravity(model, work)
    apply_given_loads(model, work, t)
    apply_contacts(model, work)
    apply_granules(model, work)


@jit
def rigid_apply_given_loads(model, work, t):
    _apply_forces(model, work, t)
    _apply_springs(model, work, ALL)
    core.apply_torsion_springs(model, work)
    core.apply_own_loads(model, work)
    if model.world.user_force[0] != 0:
        _apply_user_force(model, work, t)


@jit
def lanes_apply_loads(model, work, t):
    """Evaluate gravity and springs that push and pull."""
    core.apply_gravity(model, work)
    _apply_springs(model, work, TWO_SIDED)
    core.apply_torsion_springs(model, work)


@jit
def lanes_apply_loads_alone(model, work, t):
    """Evaluate gravity and springs, and let the system of each lane add what depends on the time or on its modes."""
    beside = work.beside
    lanes_apply_loads(model, work, t)
    for w in range(WIDTH):
        if beside.model[w] != 0:
            own, its = alone(model, beside.model[w]), alone(work, beside.work[w])
            if beside.always[0] == 1 or _pushes(own):
                core.take_kinematics(work, w, its)
                clear(its.kinematics.force)
                apply_further_loads(own, its, lane_of(t, w))
                add_lane(its.kinematics.force, w, work.kinematics.force)


@bare
def _pushes(model):
    """Return whether a contact or a spring that only pulls may have a force in its mode."""
    modes = model.contact_modes
    for k in range(modes.mode.shape[0] - model.watches.a.shape[0]):
        if modes.mode[k] in (law.MODE_CLOSED, law.MODE_PLAIN, law.MODE_LIMITED):
            return True
    return False


@jit
def rigid_apply_further_loads(model, work, t):
    _apply_forces(model, work, t)
    _apply_springs(model, work, ONE_SIDED)
    core.apply_own_loads(model, work)
    apply_contacts(model, work)
    apply_granules(model, work)


# --- springs ----------------------------------------------------------------------------------------


@bare
def _clipped_by_mode(spring, modes, k, stretch, tension):
    place = spring.place[k]
    if place < 0 or modes.mode[place] == law.MODE_CLOSED:
        return tension
    if modes.mode[place] == law.MODE_LIMITED:
        return spring.limit[k]
    return min(max(tension, 0.0), spring.limit[k]) if stretch > 0.0 else 0.0


# Return the pull of a spring whose law, without clipping, gives `tension`. It follows from the frozen mode, or from the
# state where events are not located; a spring that may push has none, as no spring in lanes has.
_clipped = either(
    "_clipped(spring, modes, k, stretch, tension)", _clipped_by_mode,
    bare(lambda spring, modes, k, stretch, tension: tension),
)  # fmt: skip


@bare
def _apply_springs(model, work, which):
    """F = k (l - l0) + c l_dot along the line of the two points (Fox 1999 eq 18 with the points' distance)."""
    spring, modes = model.springs, model.contact_modes
    for k in range(spring.a.shape[0]):
        place = spring.place[k]
        if (which == TWO_SIDED and place >= 0) or (which == ONE_SIDED and place < 0):
            continue
        if place >= 0 and modes.mode[place] in (law.MODE_OPEN, law.MODE_LIFTED):
            continue
        a, b = spring.a[k], spring.b[k]
        apart = separation(work, a, b, spring.point_a[k], spring.point_b[k])
        gap, rate, arm_a = apart.gap, apart.rate, apart.arm_a
        length = np.sqrt(core.dot(work, gap, gap))
        stretch = length - spring.rest_length[k]
        if spring.isotropic[k] == 1:
            # against body a's matter at b's mark, where both forces act
            rate, arm_a = rate_seen(work, a, gap, rate), core.plus(work, arm_a, gap)
            elastic = core.times(work, spring.stiffness[k], gap)
            force = core.plus(work, elastic, core.times(work, spring.damping[k], rate))
        elif vanishes(length):
            force = core.times(work, spring.damping[k], rate)  # no line of action: the isotropic limit of the damper
        else:
            tension = spring.stiffness[k] * stretch + spring.damping[k] * core.dot(work, gap, rate) / length
            force = core.pull(work, _clipped(spring, modes, k, stretch, tension), gap, length)
        exchange(work, a, arm_a, b, apart.arm_b, force)


@bare
def distance(work, a, b, point_a, point_b):
    """Return the distance (m) of a point of body a from one of body b, and its rate, 0 where they coincide."""
    apart = separation(work, a, b, point_a, point_b)
    length = np.sqrt(core.dot(work, apart.gap, apart.gap))
    return length, core.dot(work, apart.gap, apart.rate) / length if length > 0.0 else 0.0


@bare
def distance_speed(work, a, b, point_a, point_b):
    """Return a bound (m/s) on the rate of the distance."""
    return speed_between(work, a, b) + core.spin(work, a) * norm(point_a) + core.spin(work, b) * norm(point_b)


@bare
def _pull(spring, work, k):
    """Return stretch, its rate, and the tension without any clipping."""
    length, rate = distance(work, spring.a[k], spring.b[k], spring.point_a[k], spring.point_b[k])
    stretch = length - spring.rest_length[k]
    return stretch, rate, spring.stiffness[k] * stretch + spring.damping[k] * rate


@bare
def spring_roots(model, work, table):
    """Fill the functions of the tension-only springs at the state in `work`."""
    spring, modes = model.springs, model.contact_modes
    noise = modes.noise[0]
    for k in range(spring.place.shape[0]):
        i = law.ROOTS_EACH * spring.place[k]
        if i < 0 or table[law.SPEED, i] == law.LEFT_OUT:
            continue
        mode = modes.mode[spring.place[k]]
        stretch, speed, tension = _pull(spring, work, k)
        slack = noise * spring.stiffness[k] + modes.noise[1] * spring.damping[k]
        a, b = spring.a[k], spring.b[k]
        sign = -1.0 if mode == law.MODE_OPEN else 1.0
        table[law.VALUE, i] = sign * stretch / noise + 1.0
        table[law.RATE, i] = sign * speed / noise
        table[law.SPEED, i] = distance_speed(work, a, b, spring.point_a[k], spring.point_b[k]) / noise
        table[law.TURN, i : i + law.ROOTS_EACH] = core.spin(work, a) + core.spin(work, b)
        if mode != law.MODE_OPEN and spring.damping[k] > 0.0:
            table[law.VALUE, i + 1] = (-tension if mode == law.MODE_LIFTED else tension) / slack + 1.0
            table[law.SPEED, i + 1] = law.UNKNOWN
        if mode in (law.MODE_CLOSED, law.MODE_LIMITED) and spring.limit[k] < np.inf:
            below = spring.limit[k] - tension
            table[law.VALUE, i + 2] = (below if mode == law.MODE_CLOSED else -below) / slack + 1.0
            table[law.SPEED, i + 2] = law.UNKNOWN


@jit
def spring_transition(model, g):
    """Change the modes whose functions are negative."""
    spring, modes = model.springs, model.contact_modes
    for k in range(spring.place.shape[0]):
        place = spring.place[k]
        if place < 0:
            continue
        i = law.ROOTS_EACH * place
        if g[i] < 0.0:
            modes.mode[place] = law.MODE_CLOSED if modes.mode[place] == law.MODE_OPEN else law.MODE_OPEN
        elif g[i + 1] < 0.0:
            modes.mode[place] = law.MODE_CLOSED if modes.mode[place] == law.MODE_LIFTED else law.MODE_LIFTED
        elif g[i + 2] < 0.0:
            modes.mode[place] = law.MODE_LIMITED if modes.mode[place] == law.MODE_CLOSED else law.MODE_CLOSED


@jit
def start_springs(model, work, located):
    """Set the modes by the state in `work`; a stretch within its roundoff is none."""
    spring, modes = model.springs, model.contact_modes
    for k in range(spring.place.shape[0]):
        place = spring.place[k]
        if place < 0:
            continue
        stretch, _, tension = _pull(spring, work, k)
        if not located:
            modes.mode[place] = law.MODE_PLAIN
        elif stretch <= modes.noise[0]:
            modes.mode[place] = law.MODE_OPEN
        else:
            modes.mode[place] = law.MODE_LIFTED if tension < 0.0 else law.MODE_CLOSED
            if tension > spring.limit[k]:
                modes.mode[place] = law.MODE_LIMITED
