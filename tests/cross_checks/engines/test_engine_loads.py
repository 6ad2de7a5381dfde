"""Engines against each other and against closed forms on every load and drive they translate."""

from __future__ import annotations

from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import pytest

from cross_checks import engines, writers
from cross_checks.engine import Engine
from mbs_ref import scenes
from mbs_ref.observables import rows
from mbs_ref.scene import GROUND, Force, PlanarBody, Scene, SpatialBody, SpringDamper, Torque
from mbs_ref.scene.contact import CircleOnLine, SphereOnPlane, SpringDamperLaw
from mbs_ref.scene.signals import Table
from mbs_ref.trajectory import Status
from tests.cross_checks.engines.engine_runs import distance, run
from tests.cross_checks.engines.loaded_scenes import loaded_tree


def test_springs_dampers_forces_and_torques_agree():
    scene = loaded_tree()
    fine = run("mujoco", "rk4", scene, step=5e-4, t_end=0.5, samples=6)
    assert fine.ok
    errors = [distance(run("exudyn", "trapezoidal", scene, step=h, t_end=0.5, samples=6), fine) for h in (2e-3, 1e-3)]
    assert errors[1] < 1e-5
    assert errors[0] == pytest.approx(4.0 * errors[1], rel=0.2)


def test_slides_in_turned_frames_agree():
    from tests.cross_checks.engines.test_engine_traps import mixed_slides

    fine = run("pinocchio", "dop853", mixed_slides(), rtol=1e-12, t_end=0.5, samples=6)
    for name, method in (("mujoco", "rk4"), ("exudyn", "tree_rk44")):
        assert distance(run(name, method, mixed_slides(), t_end=0.5, samples=6), fine) < 1e-9


def test_pinocchio_takes_every_load_through_the_applied_forces():
    scene = loaded_tree()
    native = run("mujoco", "rk4", scene, step=5e-4, t_end=0.5, samples=6)
    driven = run("pinocchio", "dop853", scene, rtol=1e-10, t_end=0.5, samples=6)
    assert distance(driven, native) < 1e-9
    assert any("come from the shared force code" in note for note in driven.notes)


def test_the_spring_pendulum_agrees():
    scene = scenes.make("spring_pendulum")
    fine = run("mujoco", "rk4", scene, step=1e-3, samples=6)
    errors = [distance(run("exudyn", "trapezoidal", scene, step=h, samples=6), fine) for h in (2e-3, 1e-3)]
    assert errors[0] == pytest.approx(4.0 * errors[1], rel=0.1)


def test_a_driven_carriage_follows_its_motion():
    scene = scenes.make("driven_pendulum")
    errors = []
    for h in (4e-3, 2e-3, 1e-3):
        result = run("exudyn", "generalized_alpha", scene, step=h, t_end=1.0, samples=6)
        assert np.abs(rows(scene, result).residual).max() < 1e-12
        errors.append(result.position[-1, 1])
    steps = [np.linalg.norm(a - b) for a, b in pairwise(errors)]
    assert steps[0] == pytest.approx(4.0 * steps[1], rel=0.1)
    assert "calls Python" in result.notes[0]


def pulled(signal, **more) -> Scene:
    block = PlanarBody(name="block", mass=2.0, inertia=0.5)
    return Scene(
        name="pulled",
        bodies=(block,),
        loads=(
            Force(name="pull", body="block", point=(0.0, 0.0), vector=(4.0, 0.0), factor=signal, **more),
            Torque(name="twist", body="block", torque=1.0, factor=signal),
        ),
    )


def test_a_tabulated_force_and_torque_move_a_free_body_exactly():
    ramp = Table(times=(0.0, 1.0), values=(0.0, 1.0))
    result = run("exudyn", "trapezoidal", pulled(ramp), step=1e-3, t_end=1.0, samples=2)
    # a = 2 t and alpha = 2 t: x = t^3 / 3
    assert result.position[-1, 0] == pytest.approx((1.0 / 3.0, 0.0), abs=1e-6)
    assert result.orientation[-1, 0] == pytest.approx(1.0 / 3.0, abs=1e-6)


def test_mujoco_takes_a_load_that_varies_in_time_from_the_shared_force_code():
    ramp = Table(times=(0.0, 1.0), values=(0.0, 1.0))
    result = run("mujoco", "rk4", pulled(ramp), step=1e-2, t_end=1.0, samples=2)
    assert result.position[-1, 0] == pytest.approx((1.0 / 3.0, 0.0), abs=1e-13)  # RK4 is exact for t^3
    assert result.orientation[-1, 0] == pytest.approx(1.0 / 3.0, abs=1e-13)
    assert any("shared force code" in note for note in result.notes)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rope_that_damps_is_none_of_mujocos_tendons(dimension):
    """Its tendons damp while they are slack too: the shared force code acts instead, and MJX refuses."""
    ends = {"body_a": GROUND, "body_b": "stone", "point_a": (0.0,) * dimension, "point_b": (2.0, 0.0, 0.0)[:dimension]}
    pose = {"name": "stone", "mass": 1.0, "position": ends["point_b"], "velocity": (1.0, 0.0, 0.0)[:dimension]}
    body = PlanarBody(inertia=1.0, **pose) if dimension == 2 else SpatialBody(inertia=(1.0,) * 3 + (0.0,) * 3, **pose)
    rope = SpringDamper(name="rope", stiffness=1.0, damping=0.1, tension_only=True, **ends)
    scene = Scene(name="rope", gravity=(0.0,) * dimension, bodies=(body,), loads=(rope,))
    own = run("mbs_ref", "rk4", scene, step=1e-3, t_end=1.0, samples=3, events="none")
    assert distance(run("mujoco", "rk4", scene, step=1e-3, t_end=1.0, samples=3), own) < 1e-12
    if "mjx" in engines.names() and find_spec("mujoco.mjx") is not None:
        refused = run("mjx", "rk4", scene)
        assert refused.status is Status.REFUSED
        assert "load 'rope': a mjx tendon damps while slack" in refused.message


def test_a_rope_pulls_and_never_pushes():
    """Thrown inwards the body flies free; thrown outwards it comes back after half a period."""
    for name, method in (("mujoco", "rk4"), ("exudyn", "trapezoidal")):
        for speed, end in ((-1.0, -1.0), (1.0, 0.0)):
            body = PlanarBody(name="stone", mass=1.0, inertia=1.0, position=(2.0, 0.0), velocity=(speed, 0.0))
            rope = SpringDamper(
                name="rope", body_a=GROUND, body_b="stone", point_a=(0.0, 0.0), point_b=(2.0, 0.0),
                stiffness=np.pi**2, rest_length=2.0, tension_only=True,
            )  # fmt: skip
            scene = Scene(name="rope", bodies=(body,), loads=(rope,))
            result = run(name, method, scene, step=1e-3, t_end=1.0, samples=2)
            assert result.position[-1, 0, 0] - 2.0 == pytest.approx(end, abs=1e-4)


def _grains(contact: bool, space: bool = False) -> Scene:
    """Return grains that press against each other from the start, perhaps above a floor of another kind."""
    scene = scenes.make("granular_column", grains=4, across=2, search=True, stiffness=1e3, damping=0.0, space=space)
    center, law = scene.bodies[0].position, SpringDamperLaw(stiffness=1e3)
    given = {"name": "floor", "body_a": "g0", "body_b": GROUND, "center": center, "radius": 0.01, "law": law}
    line, plane = {"point_1": (0.0, 0.0), "point_2": (1.0, 0.0)}, {"point": (0.0,) * 3, "normal": (0.0, 0.0, 1.0)}
    floor = SphereOnPlane(**given, **plane) if space else CircleOnLine(**given, **line, extent="line")
    group = scene.loads[0].model_copy(update={"radius": (0.06,)})
    return scene.model_copy(update={"loads": (group,), "contacts": (floor,) if contact else ()})


def installed() -> list[Engine]:
    found = []
    for name in engines.names():
        try:
            found.append(engines.get(name))
        except engines.EngineMissing:
            continue
    return found


@pytest.mark.parametrize("contact", [False, True])
def test_granules_act_in_every_method_that_does_not_refuse_them(contact):
    scene = _grains(contact)
    settings = {"t_end": 0.01, "samples": 2, "estimate": "off", "reactions": False}
    true = run("mbs_ref", "dop853", scene, **settings)
    pushed = distance(true, run("mbs_ref", "dop853", scene.model_copy(update={"loads": ()}), **settings))
    assert pushed > 1e-3
    for engine in installed():
        for method in engine.able(scene):
            path = run(engine.name, method.name, scene, step=1e-4, rtol=1e-6, **settings)
            assert distance(path, true) < 0.1 * pushed, (engine.name, method.name)


@pytest.mark.parametrize("space", [False, True])
@pytest.mark.parametrize("contact", [False, True])
def test_what_has_no_granules_of_its_own_refuses_them_by_name(contact, space):
    scene = _grains(contact, space)
    for engine in installed():
        named = "granules" not in engine.part_types
        for method in engine.methods():
            if named or method.name in ("contact_rk44", "pair_contact_rk44"):
                assert "granules" in engine.refusal(scene, method), (engine.name, method.name)
    for form in writers.forms():
        with pytest.raises((writers.NotWritable, engines.EngineMissing), match=r"granules|needs the package"):
            writers.write(scene, form)
