"""Closures eliminated at the apex of their loops, against the augmented matrix solved as a whole."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.loops import Closure, loops_of_closures
from mbs_ref.cores.spatial import SpatialSystem
from mbs_ref.cores.system import System
from mbs_ref.kernels.rigid.model import Loops
from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene, SpatialBody
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

AGREEMENT = 1e-11  # of the largest acceleration: two eliminations of systems of condition 1e3 or so
G = 9.81  # m/s^2


def rod(name: str, a: tuple[float, float], b: tuple[float, float]) -> PlanarBody:
    (xa, ya), (xb, yb) = a, b
    length = math.hypot(xb - xa, yb - ya)
    return PlanarBody(
        name=name, mass=length, inertia=length**3 / 12.0, position=(0.5 * (xa + xb), 0.5 * (ya + yb)),
        angle=math.atan2(yb - ya, xb - xa),
    )  # fmt: skip


def raft(loops: int) -> Scene:
    """A row of leaning four-bars on a free body, which is the apex of all."""
    feet = [(float(k), 0.0) for k in range(loops + 1)]
    tips = [(x + 0.3, 1.0 + 0.1 * k) for k, (x, _) in enumerate(feet)]
    bodies = [rod("raft", feet[0], feet[-1])]
    joints = []
    for k, (foot, tip) in enumerate(zip(feet, tips, strict=True)):
        bodies.append(rod(f"crank{k}", foot, tip))
        joints.append(Revolute(name=f"A{k}", body_a="raft", body_b=f"crank{k}", point=foot))
    for k, (one, two) in enumerate(pairwise(tips)):
        bodies.append(rod(f"bar{k}", one, two))
        joints.append(Revolute(name=f"B{k}", body_a=f"crank{k}", body_b=f"bar{k}", point=one))
        joints.append(Revolute(name=f"C{k}", body_a=f"bar{k}", body_b=f"crank{k + 1}", point=two))
    return Scene(name="raft", gravity=(0.0, -G), bodies=tuple(bodies), joints=tuple(joints))


def tower(floors: int) -> Scene:
    """Four-bars one on the other, each the base of the next: every loop has an apex of its own."""
    bodies, joints, base = [], [], GROUND
    for k in range(floors):
        corners = [(0.1 * k, float(k)), (1.0 + 0.1 * k, float(k)), (0.2 + 0.1 * k, k + 1.0), (1.1 + 0.1 * k, k + 1.05)]
        bodies += [rod(f"left{k}", corners[0], corners[2]), rod(f"right{k}", corners[1], corners[3])]
        bodies.append(rod(f"floor{k}", corners[2], corners[3]))
        for side, foot, tip in (("left", corners[0], corners[2]), ("right", corners[1], corners[3])):
            joints.append(Revolute(name=f"{side}{k}.foot", body_a=base, body_b=f"{side}{k}", point=foot))
            joints.append(Revolute(name=f"{side}{k}.tip", body_a=f"{side}{k}", body_b=f"floor{k}", point=tip))
        base = f"floor{k}"
    return Scene(name="tower", gravity=(0.0, -G), bodies=tuple(bodies), joints=tuple(joints))


def net(columns: int, rows: int) -> Scene:
    """A net of rods between pins: loops share bodies in both directions."""
    place = {(i, j): (i + 0.13 * j * j, -j - 0.07 * i) for i in range(columns) for j in range(rows)}
    edges = [((i, j), (i + 1, j)) for i in range(columns - 1) for j in range(1, rows)]
    edges += [((i, j), (i, j + 1)) for i in range(columns) for j in range(rows - 1)]
    names = {edge: f"rod{k}" for k, edge in enumerate(edges)}
    joints = []
    for pin, point in place.items():
        here = [names[edge] for edge in edges if pin in edge]
        hub = GROUND if pin[1] == 0 else here.pop(0)
        for name in here:
            joints.append(Revolute(name=f"{hub}-{name}", body_a=hub, body_b=name, point=point))
    bodies = tuple(rod(name, place[edge[0]], place[edge[1]]) for edge, name in names.items())
    return Scene(name="net", gravity=(0.0, -G), bodies=bodies, joints=tuple(joints))


def lifted(scene: Scene) -> Scene:
    """The same in space, where three rows of every loop are redundant."""
    bodies = []
    for body in scene.bodies:
        assert isinstance(body, PlanarBody)
        half = 0.5 * body.angle
        bodies.append(SpatialBody(
            name=body.name, mass=body.mass, inertia=(0.1 * body.inertia, body.inertia, body.inertia, 0.0, 0.0, 0.0),
            position=(*body.position, 0.0), orientation=(math.cos(half), 0.0, 0.0, math.sin(half)),
        ))  # fmt: skip
    joints = tuple(
        Revolute(name=j.name, body_a=j.body_a, body_b=j.body_b, point=(*j.point, 0.0), axis=(0.0, 0.0, 1.0))
        for j in scene.joints
        if isinstance(j, Revolute)
    )
    return Scene(name=scene.name, gravity=(0.0, -G, 0.0), bodies=tuple(bodies), joints=joints)


def spun(system: System, scale: float = 1.0) -> np.ndarray:
    """Return the first state with rates that the joints allow."""
    y = system.initial_state()
    y[system.n_positions :] += scale * np.random.default_rng(3).standard_normal(len(y) - system.n_positions)
    system.project(0.0, y)
    return y


def whole(system: System, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return M, C_q and the accelerations of the augmented system, solved as a whole by least squares."""
    if isinstance(system, SpatialSystem):
        force, jacobian, mass = system.applied_forces(0.0, y).ravel(), system.jacobian(0.0, y), system.mass_matrix()
    else:
        force, jacobian = system.applied_forces(0.0, y).ravel(), system.jacobian(0.0, y)
        mass = np.diag(system.mass_matrix())
    gamma = system.right_side()
    m, n = jacobian.shape
    matrix = np.block([[mass, jacobian.T], [jacobian, np.zeros((m, m))]])
    answer = np.linalg.lstsq(matrix, np.concatenate((force, gamma)), rcond=1e-12)[0]
    return mass, jacobian, answer[:n]


SCENES = [raft(1), raft(5), tower(4), net(4, 3), lifted(raft(3)), lifted(tower(3)), lifted(net(3, 3))]


@pytest.mark.parametrize("scene", SCENES, ids=lambda s: f"{s.name}-{len(s.bodies)}-{s.dimension}d")
def test_against_the_augmented_matrix(scene):
    system = compile_scene(scene)
    system.set_mode_time(0.0)
    y = spun(system)
    mass, jacobian, truth = whole(system, y)
    a = system.accelerations(0.0, y).ravel()
    assert np.abs(a - truth).max() < AGREEMENT * np.abs(truth).max()
    force = mass @ a + jacobian.T @ system.multipliers(0.0, y)
    again = mass @ truth + jacobian.T @ np.linalg.lstsq(jacobian.T, force - mass @ truth, rcond=1e-12)[0]
    assert np.abs(force - again).max() < 1e3 * AGREEMENT * np.abs(force).max()


@pytest.mark.parametrize("scene", [lifted(raft(3)), lifted(tower(3)), lifted(net(3, 3))], ids=lambda s: s.name)
def test_ranks_of_closures_add_up_to_that_of_the_rows(scene):
    system = SpatialSystem(scene)
    system.set_mode_time(0.0)
    y = spun(system)
    rank = JointedSystem.rank(system, 0.0, y)  # without the norms
    system.derivative(0.0, y)
    independent_of_tree = len(system.rows()) - system.n_closure_rows
    assert system.groups.loops.most.sum() == system.scratch.closures.rank.sum() == rank - independent_of_tree


def test_a_redundant_row_is_left_out_off_the_constraints_too():
    """0.1 mm off, Bricard's fifth row is independent by 1e-8, and asks for accelerations of its own: of 10 m/s^2."""
    system = compile_scene(scenes.make("bricard"))
    system.set_mode_time(0.0)
    y, off = spun(system), 1e-4
    left = y.copy()
    left[: system.n_positions] += off * np.random.default_rng(5).standard_normal(system.n_positions)
    closed = system.accelerations(0.0, y).ravel()
    change = np.abs(system.accelerations(0.0, left).ravel() - closed).max()
    assert 1.0 < np.abs(closed).max() < 10.0
    assert 0.1 * off < change < 100.0 * off


def later(loops: Loops) -> list[set[int]]:
    return [set(loops.met[a:b].tolist()) for a, b in pairwise(loops.first)]


def test_a_row_of_loops_is_taken_from_one_end_to_the_other():
    loops = compile_scene(scenes.make("n_four_bar", loops=200)).groups.loops
    assert later(loops) == [{k + 1} for k in range(199)] + [set()]


def test_loops_of_a_tower_meet_nobody():
    loops = compile_scene(tower(50)).groups.loops
    assert len(loops.met) == 0
    assert len(loops.here) == 3 * 50


@pytest.mark.parametrize("seed", range(5))
def test_every_fill_is_foreseen(seed):
    """Eliminate the pattern of whole paths by hand: bodies leaf to root, closures before their apex."""
    random = np.random.default_rng(seed)
    n, m = 30, 25
    parent = [int(random.integers(0, i)) if i and random.random() < 0.9 else n for i in range(n)]
    pairs = [tuple(int(i) for i in random.choice(n + 1, 2, replace=False)) for _ in range(m)]
    loops = loops_of_closures(parent, [Closure(n + k, pair, 1) for k, pair in enumerate(pairs)])
    touches = [set(pairs[slot - n]) - {n} for slot in loops.slot]  # bodies that a closure's rows are on
    meets: list[set[int]] = [set() for _ in touches]

    def eliminate(k: int) -> None:
        left = {s for s in meets[k] if s > k}
        assert left == set(loops.met[loops.first[k] : loops.first[k + 1]].tolist())
        for s in left:
            meets[s] |= left - {s}
            touches[s] |= touches[k]
        touches[k] = set()

    for body in [*range(n - 1, -1, -1), n]:
        for k in range(*loops.closed[body]):
            assert touches[k] <= {body}
            eliminate(k)
        if body == n:
            break
        here = [k for k in range(m) if body in touches[k]]
        assert here == loops.passing[loops.entry[body] : loops.entry[body + 1]].tolist()
        for k in here:
            meets[k] |= set(here) - {k}
            touches[k] -= {body}
            touches[k] |= {parent[body]} - {n}


@pytest.mark.parametrize(("name", "least"), [("n_four_bar", 0.14), ("spatial_n_four_bar", 0.11)])
def test_regularity_is_of_the_pose_and_not_of_the_number_of_loops(name, least):
    """Upright cranks are as far from a singular pose as they can be, however many they are."""
    for loops in (10, 100):
        system = compile_scene(scenes.make(name, loops=loops))
        system.derivative(0.0, system.initial_state())
        assert system.regularity() > least


def test_a_flat_pose_is_singular_for_every_loop():
    system = compile_scene(scenes.make("n_four_bar", loops=30))
    y = system.initial_state()
    y[0 : 3 * 31].reshape(-1, 3)[:] = [(k + 0.5, 0.0, 0.0) for k in range(31)]
    y[3 * 31 : 3 * 61].reshape(-1, 3)[:] = [(k + 1.5, 0.0, 0.0) for k in range(30)]
    system.derivative(0.0, y)
    assert system.scratch.closures.rank.tolist() == [1] * 30


def test_many_loops_pass_their_singular_poses_at_a_tight_tolerance():
    """All cranks turn as one: [(N + 1) / 3 + N] L th'' = [(N + 1) / 2 + N] g sin th, th from upright."""
    loops, t_end = 60, 1.5
    k = (1.5 * loops + 0.5) / ((4 * loops + 1) / 3.0) * G
    pendulum = Scene(
        name="pendulum", gravity=(0.0, -2.0 * k), duration=t_end,
        bodies=(PlanarBody(name="rod", mass=1.0, inertia=0.75, position=(0.0, 0.5), angle=0.5 * math.pi,
                           velocity=(0.5, 0.0), angular_velocity=-1.0),),
        joints=(Revolute(name="pin", body_a=GROUND, body_b="rod", point=(0.0, 0.0)),),
    )  # fmt: skip
    settings = Settings(method="dop853", rtol=1e-12, t_end=t_end, samples=4, estimate="off", reactions=False)
    run, truth = simulate(scenes.make("n_four_bar", loops=loops), settings), simulate(pendulum, settings)
    assert run.ok, run.message
    assert np.abs(run.orientation[:, 0] - truth.orientation[:, 0]).max() < 1e-9
