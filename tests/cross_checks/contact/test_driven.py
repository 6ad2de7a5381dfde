"""Engines that drivers run: the geometry of contacts, translations, refusals, and what a driver prints."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cross_checks import contact
from cross_checks import contact as driven
from cross_checks.contact.by_figure import measured
from cross_checks.contact.drivers import contacts
from cross_checks.contact.request import Request
from cross_checks.isolation import environments
from cross_checks.judge.one_run import checked_run
from mbs_ref import Settings, Status, scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import relative_motion
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.contact import RigidLaw, RollingFriction, SphereOnPlane, SphereOnSphere, SpringDamperLaw
from mbs_ref.scene.euler_parameters import product
from mbs_ref.trajectory import Trajectory

LAW = SpringDamperLaw(stiffness=1e5, damping=100.0, release="force")
ONE = {"mass": 2.0, "inertia": (0.1, 0.2, 0.25, 0.0, 0.0, 0.0)}
TURNS = (0.5, 0.5, 0.5, 0.5), (0.6, 0.0, 0.8, 0.0)


def _pair(kind, **more) -> Scene:
    poses = [{"name": f"b{k}", "position": (0.3 * k, 0.1, -0.2 * k), "orientation": q} for k, q in enumerate(TURNS)]
    bodies = tuple(SpatialBody.model_validate(ONE | pose) for pose in poses)
    one = kind.model_validate({"name": "pair", "body_a": "b0", "body_b": "b1", "law": LAW} | more)
    return Scene(name="pair", duration=0.01, bodies=bodies, contacts=(one,))


FLAT = {"center": (0.1, 0.1, 0.05), "radius": 0.02, "point": (0.2, 0.1, 0.0), "normal": (0.2, 0.1, 1.0)}
ROUND = {"center_a": (0.1, 0.1, 0.05), "radius_a": 0.02, "center_b": (0.25, 0.1, -0.2), "radius_b": 0.1}


@pytest.mark.parametrize(("kind", "more"), [(SphereOnPlane, FLAT), (SphereOnSphere, ROUND)])
def test_gap_and_normal_of_a_driver_are_those_of_the_scene_in_any_pose(kind, more):
    scene = _pair(kind, **more)
    model = driven.linkage_of(scene)
    one, random = driven._contact(model, scene.contacts[0], 1e-4), np.random.default_rng(4)
    for _ in range(5):
        turns = random.standard_normal((2, 4))
        turns /= np.linalg.norm(turns, axis=1, keepdims=True)
        places = random.uniform(-0.3, 0.3, (2, 3))
        still = np.zeros((1, 2, 3))
        path = Trajectory(np.zeros(1), places[None], product(turns, np.array(TURNS))[None], still, still)
        gap, normal, _ = relative_motion(Motion(scene, path), scene.contacts[0])
        poses = list(zip(places.tolist(), turns.tolist(), strict=True))
        found, direction, _ = contacts.touch(one, poses)
        assert found == pytest.approx(float(gap[0]), abs=1e-12)
        assert direction == pytest.approx(normal[0].tolist(), abs=1e-12)


def test_a_damping_below_that_of_a_step_is_refused_by_name():
    request = Request(rebound=0.99, friction=0.3, stiffness=1e5, mass=2.0, step=1e-3)
    refused = driven.translate("ode", request).refused
    assert set(refused) == {"restitution", "duration, s", "penetration, m"}
    rigid = driven.translate("siconos", request)
    assert set(rigid.refused) == {"duration, s", "penetration, m", "static sink, m"}
    assert rigid.parameters == {"e": 0.99, "mu": 0.3}


def test_parameters_of_ode_are_a_spring_and_a_damper():
    request = Request(rebound=0.5, friction=0.7, stiffness=1e5, mass=2.0, step=1e-4)
    found: Any = driven.translate("ode", request).parameters
    erp, cfm, h = found["soft_erp"], found["soft_cfm"], 1e-4
    assert erp / (h * cfm) == pytest.approx(1e5)  # N/m (ODE's manual, section 3.8)
    assert (1.0 - erp) / cfm + 1e5 * h == pytest.approx(request.law.damping)


@pytest.fixture
def engine(tmp_path, monkeypatch):
    """An engine whose driver sends its first body 1 m along x at every output, and ends at the third."""
    script = tmp_path / "driver.py"
    script.write_text(
        "import json, sys\np = json.load(sys.stdin)\n"
        "for k in range(1, min(len(p['counts']), 3) + 1):\n"
        "    b = p['bodies'][0]\n"
        "    print([[k, *b['position'][1:], 1, 0, 0, 0, *b['velocity'], *b['spin']]] * len(p['bodies']))\n"
    )
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python").symlink_to(sys.executable)
    one = driven.Driven("ode", tmp_path)
    one.script = script
    return one


def test_rows_of_a_driver_are_poses_and_an_early_end_is_a_status(engine):
    scene = scenes.make("sliding_block", height=0.0)
    path = engine.run(scene, Settings(step=1e-3), np.array((0.0, 0.1, 0.2)))
    assert path.ok, path.message
    assert path.position[1:, 0, 0].tolist() == [1.0, 2.0]
    path = engine.run(scene, Settings(step=1e-3), np.linspace(0.0, 0.5, 6))
    assert path.status is Status.ENGINE_ERROR
    assert "driver ended with code 0" in path.message
    assert len(path.times) == 4


def test_what_a_driver_lacks_is_named(engine):
    scene = _pair(SphereOnPlane, **FLAT, friction=RollingFriction(coefficient=0.3, lever=0.01))
    assert "resistance to rolling" in engine.refusal(scene, engine.method(None))
    assert "no part type 'distance'" in engine.refusal(scenes.make("pendulum"), engine.method(None))
    engine.name = "bullet"
    assert "endless planes on ground alone" in engine.refusal(_pair(SphereOnPlane, **FLAT), engine.method("impulses"))


def test_bodies_that_bullet_would_run_otherwise_are_refused(engine):
    """Its driver gives a body a diagonal inertia, and one stiffness, damping and friction for all contacts."""
    engine.name, tilted = "bullet", _pair(SphereOnSphere, **ROUND)
    method = engine.method("impulses")
    assert "principal axes" in engine.refusal(tilted, method)
    bodies = tuple(body.model_copy(update={"orientation": TURNS[0]}) for body in tilted.bodies)  # a third of a turn
    straight = tilted.model_copy(update={"bodies": bodies})
    assert not engine.refusal(straight, method)
    (first,) = straight.contacts
    soft = first.model_copy(update={"name": "soft", "law": LAW.model_copy(update={"stiffness": 1e4})})
    assert "one law" in engine.refusal(straight.model_copy(update={"contacts": (first, soft)}), method)
    swapped = first.model_copy(update={"body_a": "ground"})
    assert "ground as body_b" in engine.refusal(straight.model_copy(update={"contacts": (swapped,)}), method)


def test_a_driver_that_hangs_is_a_failure_and_a_rebound_of_0_is_sent(engine, monkeypatch):
    engine.script.write_text("import time\ntime.sleep(60)\n")
    monkeypatch.setattr(driven, "LONG", 0.1)
    scene = scenes.make("sliding_block", height=0.0)
    outcome = checked_run(engine, scene, Settings(step=1e-3), np.array((0.0, 0.1)))
    assert not isinstance(outcome, Trajectory)
    assert (outcome[0], "more than 0.1 s" in outcome[1]) == ("engine-error", True)
    plastic = _pair(SphereOnSphere, **ROUND | {"law": RigidLaw(restitution=0.0)})
    assert driven._contact(driven.linkage_of(plastic), plastic.contacts[0], 1e-4)["rebound"] == 0.0


def test_an_engine_without_an_environment_is_absent(tmp_path, monkeypatch):
    monkeypatch.setenv(environments.FOLDER, str(tmp_path))
    assert contact.model_of("siconos") == "not installed"
    (tmp_path / "siconos.json").write_text(json.dumps({"environment": str(tmp_path)}))
    found = contact.model_of("siconos")
    assert not isinstance(found, str)
    assert found.engine.methods()[0].name == "moreau"


@pytest.mark.slow
@pytest.mark.parametrize("name", [*contact.DRIVEN, "dart", "mjx", "newton"])
def test_an_engine_elsewhere_obtains_what_was_requested(name):
    model = contact.model_of(name)
    if isinstance(model, str):
        pytest.skip(f"{name}: {model}")
    request = Request(rebound=0.5, friction=0.7, stiffness=1e5, mass=2.0, step=1e-4)
    translation = model.translate(request)
    for one in measured(model, request, translation):
        refused = translation.refused.get(one.figure)
        stated = refused.instead if refused else one.requested
        if stated:
            assert one.obtained == pytest.approx(stated, rel=0.02), one


assert Path(contacts.__file__).parent == driven.DRIVERS
