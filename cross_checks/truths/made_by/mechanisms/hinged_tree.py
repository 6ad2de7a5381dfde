"""A tree of hinged planar bodies on a free root, in absolute angles: Lagrange's and Hamilton's equations.

The bodies that are welded to ground are ground. y holds the root's place x, y (m), then every body's
angle (rad), then as many rates or momenta.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cross_checks.truths.made_by.agreement import Formulation
from cross_checks.truths.made_by.mechanisms import hinged_tree_loads
from cross_checks.truths.made_by.mechanisms.hinged_tree_loads import Loads, loads_of, mark, planar
from cross_checks.truths.made_by.mechanisms.rod_chain import factor_and_solve
from cross_checks.truths.truth import OutsideDomainError
from mbs_ref.kernels.jit import strict_jit
from mbs_ref.scene import GROUND, Revolute, Scene, Weld


class Tree(NamedTuple):
    """r_i = r_root + sum_k R(theta_k) arm[i, k]; compiled code takes it as it is."""

    arm: np.ndarray  # (n, n, 2) m, in body k's axes; zero where k is not between the root and i
    mass: np.ndarray  # (n,) kg
    inertia: np.ndarray  # (n,) kg m^2
    coupling: np.ndarray  # (2, n, n) kg m^2: M_jk = [0] cos(theta_j - theta_k) + [1] sin(theta_j - theta_k)


def formulations(scene: Scene) -> tuple[Formulation, Formulation]:
    """Return Lagrange's and Hamilton's equations; OutsideDomainError where the mechanism is of another kind."""
    fixed = {GROUND, *(j.body_b for j in scene.joints if isinstance(j, Weld) and j.body_a == GROUND)}
    free = [body.name for body in scene.bodies if body.name not in fixed]
    tree, loads = _tree(scene, free, _hinges(scene, free)), loads_of(scene, free)
    rates = _start(scene, free)
    momenta, n = rates.copy(), len(rates) // 2
    momenta[n:] = _mass_matrix(tree, _turned_arms(tree, rates), rates) @ rates[n:]
    known = scene, free, tree, loads
    lagrange = _formulation(*known, _lagrange_slope, lambda y: y, rates)
    return lagrange, _formulation(
        *known, _hamilton_slope, lambda y: _with_rates(tree, _turned_arms(tree, y), y), momenta
    )


def _hinges(scene: Scene, free: list[str]) -> dict[str, Revolute]:
    """Return the hinge that carries each body, the root's excepted, every carrier before what it carries."""
    hinges = [j for j in scene.joints if isinstance(j, Revolute)]
    welds = [j for j in scene.joints if isinstance(j, Weld)]
    carrying: dict[str, Revolute] = {}
    reached = [free[0]]
    for body in reached:
        for joint in hinges:
            other = {joint.body_a: joint.body_b, joint.body_b: joint.body_a}.get(body)
            if other is not None and other not in reached:
                carrying[other] = joint
                reached.append(other)
    if len(reached) < len(free) or len(hinges) != len(free) - 1 or len(hinges) + len(welds) < len(scene.joints):
        raise OutsideDomainError(f"{scene.name!r} is no free tree of hinged bodies")
    return carrying


def _tree(scene: Scene, free: list[str], hinge: dict[str, Revolute]) -> Tree:
    n = len(free)
    arm = np.zeros((n, n, 2))
    for child, joint in hinge.items():
        parent = joint.body_a if joint.body_b == child else joint.body_b
        (i, outwards), (p, along) = (mark(scene, free, name, joint.point) for name in (child, parent))
        arm[i] = arm[p]
        arm[i, p] += along
        arm[i, i] -= outwards
    bodies = [planar(scene, name) for name in free]
    mass, inertia = np.array([b.mass for b in bodies]), np.array([b.inertia for b in bodies])
    cosine = np.einsum("i,ijc,ikc->jk", mass, arm, arm) + np.diag(inertia)
    x, y = arm[..., 0], arm[..., 1]
    sine = np.einsum("i,ij,ik->jk", mass, x, y) - np.einsum("i,ij,ik->jk", mass, y, x)
    return Tree(arm, mass, inertia, np.stack((cosine, sine)))


def _formulation(
    scene: Scene, free: list[str], tree: Tree, loads: Loads, slope: Callable, rates_of: Callable, start: np.ndarray
) -> Formulation:
    """Return the equations y' = slope(...) of a state whose rates are those of rates_of(y)."""

    def frozen(t, y, on):
        return slope(tree, loads.arrays, loads.factors(t), y, on)

    def switches(t, y):
        return _switches(tree, loads.arrays, rates_of(y))

    def poses(t, y):
        return _all_poses(scene, free, _motion(tree, _turned_arms(tree, y), y)[0][:-1])

    def derivative(t, y):
        values = switches(t, y)  # NaN in a trial step that goes too far; error control then rejects the step
        return frozen(t, y, values > 0.0) if not np.isnan(values).any() else np.full(len(y), np.nan)

    def known(t, y):
        values = switches(t, y)
        if np.isnan(values).any():
            raise OutsideDomainError("a circle is deeper than its surface is thick")
        return values

    return Formulation(derivative, start, poses, frozen, known, tuple(scene.breakpoints()))


def _start(scene: Scene, free: list[str]) -> np.ndarray:
    bodies = [planar(scene, name) for name in free]
    place, speed = [*bodies[0].position, *(b.angle for b in bodies)], [*bodies[0].velocity]
    return np.array([*place, *speed, *(b.angular_velocity for b in bodies)])


def _all_poses(scene: Scene, free: list[str], moving: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    bodies = [planar(scene, name) for name in scene.body_names]
    poses = np.array([[*b.position, b.angle] for b in bodies])
    poses[[scene.body_index(name) for name in free]] = moving
    return poses[:, :2], poses[:, 2]


@strict_jit
def _turned_arms(tree, y):
    """R(theta_k) arm[i, k], (n, n, 2)."""
    n = tree.mass.shape[0]
    turned = np.zeros((n, n, 2))
    for k in range(n):
        c, s = np.cos(y[2 + k]), np.sin(y[2 + k])
        for i in range(n):
            ux, uy = tree.arm[i, k]
            turned[i, k, 0] = c * ux - s * uy
            turned[i, k, 1] = s * ux + c * uy
    return turned


@strict_jit
def _motion(tree, turned, y):
    """Poses and rates (n + 1, 3) of the bodies, ground last, and h (n, 2)."""
    n = tree.mass.shape[0]
    pose, rate, bend = np.zeros((n + 1, 3)), np.zeros((n + 1, 3)), np.zeros((n, 2))
    v = y[n + 2 :]
    for i in range(n):
        pose[i, 0], pose[i, 1], pose[i, 2] = y[0], y[1], y[2 + i]
        rate[i, 0], rate[i, 1], rate[i, 2] = v[0], v[1], v[2 + i]
        for k in range(n):
            ax, ay = turned[i, k]
            w = v[2 + k]
            pose[i, 0] += ax
            pose[i, 1] += ay
            rate[i, 0] -= w * ay
            rate[i, 1] += w * ax
            bend[i, 0] += w * w * ax
            bend[i, 1] += w * w * ay
    return pose, rate, bend


@strict_jit
def _mass_matrix(tree, turned, y):
    n = tree.mass.shape[0]
    m = np.zeros((n + 2, n + 2))
    for i in range(n):
        m[0, 0] += tree.mass[i]
        m[1, 1] += tree.mass[i]
        for k in range(n):
            m[0, 2 + k] -= tree.mass[i] * turned[i, k, 1]
            m[1, 2 + k] += tree.mass[i] * turned[i, k, 0]
    c, s = np.cos(y[2 : n + 2]), np.sin(y[2 : n + 2])
    for j in range(n):
        m[2 + j, 0], m[2 + j, 1] = m[0, 2 + j], m[1, 2 + j]
        for k in range(n):
            cosine, sine = c[j] * c[k] + s[j] * s[k], s[j] * c[k] - c[j] * s[k]
            m[2 + j, 2 + k] = tree.coupling[0, j, k] * cosine + tree.coupling[1, j, k] * sine
    return m


@strict_jit
def _generalized(turned, force):
    """J^T of forces (n + 1, 3) at the centres of mass."""
    n = turned.shape[0]
    q = np.zeros(n + 2)
    for i in range(n):
        q[0] += force[i, 0]
        q[1] += force[i, 1]
        q[2 + i] += force[i, 2]
        for k in range(n):
            q[2 + k] += turned[i, k, 0] * force[i, 1] - turned[i, k, 1] * force[i, 0]
    return q


@strict_jit
def _switches(tree, arrays, y):
    pose, rate, _ = _motion(tree, _turned_arms(tree, y), y)
    return hinged_tree_loads.measure_switches(arrays, pose, rate)


@strict_jit
def _lagrange_slope(tree, arrays, factors, y, on):
    """M q'' = J^T (F + m h) with r'' = J q'' - h."""
    n = tree.mass.shape[0]
    turned = _turned_arms(tree, y)
    pose, rate, bend = _motion(tree, turned, y)
    force = hinged_tree_loads.apply_loads(arrays, tree.mass, factors, pose, rate, on)
    for i in range(n):
        force[i, 0] += tree.mass[i] * bend[i, 0]
        force[i, 1] += tree.mass[i] * bend[i, 1]
    slope = np.empty(2 * n + 4)
    slope[: n + 2] = y[n + 2 :]
    slope[n + 2 :] = factor_and_solve(_mass_matrix(tree, turned, y), _generalized(turned, force))
    return slope


@strict_jit
def _with_rates(tree, turned, y):
    """Momenta to rates."""
    n = tree.mass.shape[0]
    moving = y.copy()
    moving[n + 2 :] = factor_and_solve(_mass_matrix(tree, turned, y), y[n + 2 :])
    return moving


@strict_jit
def _hamilton_slope(tree, arrays, factors, y, on):
    """p = M q', p' = J^T F + J'^T m v."""
    n = tree.mass.shape[0]
    turned = _turned_arms(tree, y)
    moving = _with_rates(tree, turned, y)
    pose, rate, _ = _motion(tree, turned, moving)
    q = _generalized(turned, hinged_tree_loads.apply_loads(arrays, tree.mass, factors, pose, rate, on))
    slope = np.empty(2 * n + 4)
    slope[: n + 2] = moving[n + 2 :]
    slope[n + 2 :] = q
    for k in range(n):
        swing = 0.0
        for i in range(n):
            swing += tree.mass[i] * (turned[i, k, 0] * rate[i, 0] + turned[i, k, 1] * rate[i, 1])
        slope[n + 4 + k] -= moving[n + 4 + k] * swing
    return slope
