"""A constraint C(q, t) = 0 of the user's own, against joints that mean the same and motions worked out otherwise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbs_ref.cores.choice import compile_scene
from mbs_ref.observables.constraints import rows
from mbs_ref.scene import (
    CoordinateDrive,
    Distance,
    PlanarBody,
    PointMass,
    PointOnPlane,
    Revolute,
    Scene,
    SpatialBody,
    Torque,
    UserConstraint,
)
from mbs_ref.scene.base.expression import FUNCTIONS, read
from mbs_ref.scene.base.taylor import Taylor
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.signals import Harmonic
from mbs_ref.scene.toml import SceneFileError, dumps, loads
from mbs_ref.scene.traits import traits
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.start_checks import InconsistentScene
from mbs_ref.trajectory import Status

ROUNDOFF = 1e-12  # m, rad and their rates, of rows of size one
GRAVITY = 9.81  # m/s^2


def bead(constraint: UserConstraint, position=(0.5, 0.25), velocity=(0.0, 0.0)) -> Scene:
    bob = PointMass(name="bead", mass=1.0, position=position, velocity=velocity)
    return Scene(name="bead", gravity=(0.0, -GRAVITY), bodies=(bob,), joints=(constraint,))


PARABOLA = UserConstraint(name="wire", body_a="ground", body_b="bead", expression="b.y - b.x ** 2")


@pytest.mark.parametrize("name", FUNCTIONS)
def test_taylor_carries_the_derivatives_of_every_function(name):
    """Against differences of the same formula in plain numbers along x = 0.4 + 0.3 s + 0.1 s^2 and y = 0.7 - s / 5."""
    takes: int = FUNCTIONS[name].nin  # type: ignore[attr-defined]
    text = f"b.x * {name}(b.x / b.y, 1 + b.y ** b.x) - 2 / b.y" if takes == 2 else f"b.y * {name}(b.x) ** 3"
    formula = read(text).formula

    def place(x, y):
        return type("Place", (), {"x": x, "y": y})()

    def along(s):
        return float(formula(0.0, None, place(0.4 + 0.3 * s + 0.1 * s * s, 0.7 - 0.2 * s)))

    x, y = Taylor(0.4, np.array([0.3, 1.0, 0.0]), 0.2), Taylor(0.7, np.array([-0.2, 0.0, 1.0]), 0.0)
    found = formula(0.0, None, place(x, y))
    h = 1e-3
    minus2, minus, here, plus, plus2 = (along(k * h) for k in (-2, -1, 0, 1, 2))
    assert found.value == pytest.approx(here, rel=1e-15)
    assert found.first[0] == pytest.approx((8 * (plus - minus) - (plus2 - minus2)) / (12 * h), rel=1e-8)
    second = (16 * (plus + minus) - (plus2 + minus2) - 30 * here) / (12 * h * h)
    assert found.second == pytest.approx(second, rel=1e-6, abs=1e-8)
    assert found.first[0] == pytest.approx(0.3 * found.first[1] - 0.2 * found.first[2], rel=1e-13)


def test_python_math_would_lose_the_derivatives_and_raises():
    with pytest.raises(TypeError):
        math.sin(Taylor(0.1, np.zeros(1), 0.0))  # type: ignore[arg-type]


def same_rows(scene: Scene, own: str, meant: str) -> None:
    """C, C_dot, C_q and gamma of two joints of a scene are the same in a general state."""
    system = compile_scene(scene)
    y = system.initial_state()
    y += 0.1 * np.random.default_rng(3).standard_normal(len(y))
    system.set_mode_time(0.3)
    system.compliance(0.3, y)
    place = {scene.joints[k].name: at for k, at in system.place.items()}
    first, second = place[own], place[meant]
    kept = system.scratch.rows
    for values in (kept.residual, kept.rate, kept.gamma):
        assert values[first.slot, first.row] == pytest.approx(values[second.slot, second.row], abs=ROUNDOFF)
    for side in range(2):
        mine = kept.jacobian[first.slot, first.side if side == 0 else 1 - first.side, first.row]
        theirs = kept.jacobian[second.slot, second.side if side == 0 else 1 - second.side, second.row]
        np.testing.assert_allclose(mine, theirs, atol=ROUNDOFF)


def test_its_rows_in_the_plane_are_those_of_the_joint_that_means_the_same():
    a = PlanarBody(name="a", mass=1.0, inertia=1.0, angle=0.4)
    b = PlanarBody(name="b", mass=2.0, inertia=1.0, position=(1.0, 0.5), angle=-0.7)
    ends = {"body_a": "a", "body_b": "b", "point_a": (0.2, -0.1), "point_b": (1.3, 0.9)}
    length = math.dist(ends["point_a"], ends["point_b"])
    own = UserConstraint(name="own", **ends, expression=f"sqrt((b.x - a.x) ** 2 + (b.y - a.y) ** 2) - {length}")
    same_rows(Scene(name="s", bodies=(a, b), joints=(own, Distance(name="rod", **ends))), "own", "rod")
    wave = Harmonic(amplitude=0.3, omega=2.0)
    own = UserConstraint(name="own", body_a="ground", body_b="b", expression="b.angle + 0.7 - 0.3 * sin(2 * t)")
    drive = CoordinateDrive(name="drive", body="b", coordinate="angle", motion=wave)
    same_rows(Scene(name="s", bodies=(a, b), joints=(own, drive)), "own", "drive")


def test_its_rows_in_space_are_those_of_the_joint_that_means_the_same():
    inertia = (1.0, 2.0, 2.5, 0.1, 0.2, 0.3)
    turned = (0.8, 0.2, -0.4, 0.4)
    a = SpatialBody(name="a", mass=1.0, inertia=inertia, orientation=turned)
    b = SpatialBody(name="b", mass=1.0, inertia=inertia, position=(1.0, 0.5, 0.2), orientation=(0.4, 0.8, -0.2, 0.4))
    point, normal = (0.3, 0.2, 0.9), np.array([1.0, 2.0, -2.0]) / 3.0
    axes = rotation_matrices(turned)

    def on_plane(_t, a, b):
        e = np.array([a.e0, a.e1, a.e2, a.e3])
        vector = np.cross(e[1:], local := axes.T @ normal)
        now = local + 2.0 * e[0] * vector + 2.0 * np.cross(e[1:], vector)
        return now @ np.array([b.x - a.x, b.y - a.y, b.z - a.z])

    ends = {"body_a": "a", "body_b": "b"}
    own = UserConstraint(name="own", **ends, point_a=point, point_b=point, function=on_plane)
    plane = PointOnPlane(name="plane", **ends, point=point, normal=tuple(normal.tolist()))
    same_rows(Scene(name="s", gravity=(0.0, 0.0, 0.0), bodies=(a, b), joints=(own, plane)), "own", "plane")
    marks = ends | {"point_a": (0.1, 0.2, 0.3), "point_b": (0.9, 0.1, -0.2)}
    length = math.dist(marks["point_a"], marks["point_b"])
    distance = f"sqrt((b.x - a.x) ** 2 + (b.y - a.y) ** 2 + (b.z - a.z) ** 2) - {length}"
    own = UserConstraint(name="own", **marks, expression=distance)
    rod = Distance(name="rod", **marks)
    same_rows(Scene(name="s", gravity=(0.0, 0.0, 0.0), bodies=(a, b), joints=(own, rod)), "own", "rod")


def parabola_at(times: np.ndarray) -> np.ndarray:
    """x of a bead on y = x^2 from rest at 0.5 m: (1 + 4 x^2) x'' = -2 x (2 x'^2 + g), from Lagrange's equation."""

    def rate(_t, z):
        return z[1], -2.0 * z[0] * (2.0 * z[1] ** 2 + GRAVITY) / (1.0 + 4.0 * z[0] ** 2)

    return solve_ivp(rate, (0.0, times[-1]), (0.5, 0.0), method="DOP853", t_eval=times, rtol=1e-12, atol=1e-14).y[0]


def test_a_bead_slides_on_a_parabola():
    run = simulate(bead(PARABOLA), Settings(rtol=1e-11, samples=21, estimate="off"))
    assert run.ok, run.message
    assert np.abs(run.position[:, 0, 0] - parabola_at(run.times)).max() < 1e-9
    judged = rows(bead(PARABOLA), run)
    assert judged.joints == ("wire",)
    assert np.abs(judged.residual).max() < 1e-13
    assert np.abs(judged.rate).max() < 1e-9


def test_the_order_of_a_method_holds_on_it():
    exact = parabola_at(np.array([0.0, 1.0]))[-1]
    settings = [Settings(method="rk4", step=h, samples=2, estimate="off") for h in (0.005, 0.0025)]
    errors = [abs(simulate(bead(PARABOLA), asked).position[-1, 0, 0] - exact) for asked in settings]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_a_pendulum_whose_length_the_user_drives():
    """l phi'' + 2 l' phi' + g sin(phi) = 0."""
    text = "hypot(b.x, b.y) - 0.5 - 0.1 * sin(3 * t)"
    constraint = UserConstraint(name="winch", body_a="ground", body_b="bead", expression=text)
    scene = bead(constraint, position=(0.5, 0.0), velocity=(0.3, 0.0))
    assert "rheonomic" in traits(scene)

    def rate(t, z):
        length, speed = 0.5 + 0.1 * math.sin(3 * t), 0.3 * math.cos(3 * t)
        return z[1], -(2.0 * speed * z[1] + GRAVITY * math.sin(z[0])) / length

    run = simulate(scene, Settings(rtol=1e-11, samples=11, estimate="off"))
    phi = solve_ivp(rate, (0.0, 1.0), (0.5 * math.pi, 0.0), "DOP853", run.times, rtol=1e-12, atol=1e-14).y[0]
    length = 0.5 + 0.1 * np.sin(3.0 * run.times)
    assert np.abs(run.position[:, 0] - np.column_stack((np.sin(phi), -np.cos(phi))) * length[:, None]).max() < 1e-9


def test_gears_that_the_user_couples():
    """theta_b = -2 theta_a: torque 1 N m on inertias 1 and 0.5 kg m^2 gives 1 / (1 + 4 x 0.5) rad/s^2."""
    numbers = (("a", 1.0, 0.0), ("b", 0.5, 3.0))
    wheels = [PlanarBody(name=name, mass=1.0, inertia=inertia, position=(x, 0.0)) for name, inertia, x in numbers]
    axles = [Revolute(name=f"axle_{w.name}", body_a="ground", body_b=w.name, point=w.position) for w in wheels]
    gear = UserConstraint(name="gear", body_a="a", body_b="b", expression="b.angle + 2 * a.angle")
    motor = Torque(name="motor", body="a", torque=1.0)
    run = simulate(Scene(name="gears", bodies=tuple(wheels), joints=(*axles, gear), loads=(motor,)), Settings())
    assert np.allclose(run.orientation[-1], (1.0 / 6.0, -1.0 / 3.0), atol=1e-9)


def test_a_ball_slides_on_an_ellipsoid_and_keeps_its_energy():
    text = "(b.x ** 2 + b.y ** 2 / 2 + b.z ** 2 / 3 - 1) / 2"
    wall = UserConstraint(name="bowl", body_a="ground", body_b="ball", expression=text)
    ball = PointMass(name="ball", mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 1.0, 0.5))
    scene = Scene(name="bowl", gravity=(0.0, 0.0, -GRAVITY), bodies=(ball,), joints=(wall,))
    run = simulate(scene, Settings(rtol=1e-11, samples=21, estimate="off"))
    energy = 0.5 * np.sum(run.velocity[:, 0] ** 2, axis=1) + GRAVITY * run.position[:, 0, 2]
    assert np.abs(energy - energy[0]).max() < 1e-9
    assert np.abs(rows(scene, run).residual).max() < 1e-12


def test_a_start_off_it_is_refused_by_name():
    with pytest.raises(InconsistentScene, match=r"'wire': position gap 0\.05"):
        simulate(bead(PARABOLA, position=(0.5, 0.3)))
    with pytest.raises(InconsistentScene, match="'wire': velocity gap 1"):
        simulate(bead(PARABOLA, velocity=(1.0, 0.0)))


def test_it_goes_through_a_file_as_a_formula_and_not_as_python():
    assert loads(dumps(bead(PARABOLA))) == bead(PARABOLA)
    own = UserConstraint(name="own", body_a="ground", body_b="bead", function=lambda t, a, b: b.x)
    with pytest.raises(SceneFileError, match="own Python function"):
        dumps(bead(own))


def test_a_file_holds_no_python():
    text = dumps(bead(PARABOLA)).replace("expression", "function")
    with pytest.raises(SceneFileError, match="is no function; in a file give an expression"):
        loads(text)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("__import__('os').system('true')", "is not allowed"),
        ("b.x.__class__", "is not allowed"),
        ("(lambda: 1)()", "is not allowed"),
        ("[b.x for x in (1, 2)]", "is not allowed"),
        ("sin(b.x, 2)", r"takes 1 argument"),
        ("b.x +", "cannot be read"),
        ("b.x - 1" + "0" * 400, "too large"),
        ("b.x" + " + b.x" * 1000, "characters"),
    ],
)
def test_what_no_formula_may_hold_is_refused(text, told):
    with pytest.raises(ValueError, match=told):
        UserConstraint(name="u", body_a="ground", body_b="bead", expression=text)


def test_coordinates_of_the_other_dimension_are_refused():
    with pytest.raises(ValueError, match=r"b\.z; allowed here: t, a\.angle"):
        bead(UserConstraint(name="u", body_a="ground", body_b="bead", expression="b.z"))
    with pytest.raises(ValueError, match="no coordinate"):
        bead(UserConstraint(name="u", body_a="ground", body_b="bead", expression="sin(t)"))


def test_a_function_that_fails_ends_the_run_with_its_reason():
    def wrong(t, a, b):
        if t > 0.5:
            raise ZeroDivisionError("no wire here")
        return b.y - b.x**2

    own = UserConstraint(name="own", body_a="ground", body_b="bead", function=wrong)
    run = simulate(bead(own), Settings(estimate="off"))
    assert run.status is Status.ENGINE_ERROR
    assert "no wire here" in run.message
