"""Scenes by an engine's own contacts: figures against closed forms and MuJoCo models of the test's own."""

import itertools

import numpy as np
import pytest

from cross_checks import contact
from cross_checks.contact import by_figure, model_of, own_engine
from cross_checks.contact.by_figure import compare, figures_of, holding, run, with_contact
from cross_checks.engine import Engine
from mbs_ref import scenes
from mbs_ref.scene.contact import RollingFriction, StickSlip
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

ANGLE = 0.2  # rad
REFUSED = {"ball_on_driven_seat"}
# s, that springs and dampers of joints and the track's links require
STEPS = {"android_spatial": 1e-4, "android_vertebral": 2e-5, "tracked_vehicle": 2e-4}


def rows(scene, engine, step, **more) -> dict[str, dict]:
    """Return the obtained figures by method and label."""
    known: dict[str, dict] = {}
    for one in compare({engine: model_of(engine)}, {scene.name: scene}, step, **more):
        known.setdefault(one.method, {})[one.figure] = one
    return known


def own_creep(option: str, along: float = 9.81 * np.sin(ANGLE), down: float = 9.81 * np.cos(ANGLE)) -> float:
    """Return the speed (m/s) at which a box of MuJoCo's own creeps on a plane with mu = 0.7; gravity in m/s^2."""
    mujoco = pytest.importorskip("mujoco")
    gravity = f"{along} 0 {-down}"
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="2e-3" gravity="{gravity}" {option}/>
      <default><geom friction="0.7 0 0" condim="3"/></default><worldbody><geom type="plane" size="0 0 1"/>
      <body pos="0 0 0.1"><freejoint/><geom type="box" size="0.2 0.15 0.1" mass="1"/></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=250)
    start = data.qpos[0]
    mujoco.mj_step(model, data, nstep=250)
    return float(data.qpos[0] - start) / 0.5


def test_a_block_creeps_as_a_box_of_mujoco_does():
    pytest.importorskip("mujoco")
    obtained = rows(holding()["slope at 29% of the cone"], "mujoco", 2e-3, every=True)
    for method, option in (("stock", ""), ("stock_impratio10", 'cone="elliptic" impratio="10"'),
                           ("stock_impratio100", 'cone="elliptic" impratio="100"')):  # fmt: skip
        creep = obtained[method]["creep, m/s"]
        assert creep.obtained == pytest.approx(own_creep(option), rel=1e-3)
        assert abs(creep.requested) < 1e-9 > creep.uncertainty  # Coulomb's law holds it
        assert abs(creep.change) < 1e-9  # no error of the step


def test_a_block_pressed_to_a_wall_creeps_as_beneath_a_larger_gravity():
    """A force through the centre presses a box of 1 kg as a gravity of as many m/s^2 does."""
    pytest.importorskip("mujoco")
    scene, gripped = holding()["pressed to a wall"], holding()["gripped by two jaws"]
    creep = own_creep('cone="elliptic" impratio="100"', 9.81, -scene.loads[0].vector[2])
    path, other = (run(model_of("mujoco"), "stock_impratio100", one, 2e-3) for one in (scene, gripped))
    assert figures_of(scene, path)["creep, m/s"] == pytest.approx(creep, rel=1e-3)
    assert 0.5 * creep < figures_of(gripped, other)["creep, m/s"] < creep  # twice the contacts, with less impedance


def test_drake_creeps_as_its_friction_is_regularised():
    """SAP in proportion to the step; else s/sqrt(1 - s^2) of the stiction tolerance of 1e-4 m/s at the share s."""
    pytest.importorskip("pydrake")
    share, block = np.tan(ANGLE) / 0.7, holding()["slope at 29% of the cone"]
    obtained = {name: one["creep, m/s"] for name, one in rows(block, "drake", 2e-3, every=True).items()}
    for method in ("similar", "lagged", "stock"):
        assert obtained[method].obtained == pytest.approx(1e-4 * share / np.sqrt(1.0 - share**2), rel=1e-3)
    assert obtained["sap"].change == pytest.approx(-0.5 * obtained["sap"].obtained, rel=1e-3)


@pytest.mark.parametrize("engine", ["mujoco", "exudyn"])
def test_a_block_stops_where_coulomb_stops_it(engine):
    pytest.importorskip(engine)
    for figures in rows(scenes.make("sliding_block"), engine, 5e-4).values():
        stop = figures["stop distance, m"]
        assert stop.requested == pytest.approx(4.0 / (2.0 * 0.3 * 9.81), abs=1e-9)
        assert stop.obtained == pytest.approx(stop.requested, rel=1e-3)


def test_mujoco_runs_each_scene_with_contact_or_says_why_not():
    pytest.importorskip("mujoco")
    engine = model_of("mujoco").engine
    reasons = {name: " ".join(r.reason for r in engine.refusals(scene)) for name, scene in with_contact().items()}
    assert len(reasons) >= 17
    refused = {name for name, reason in reasons.items() if reason}
    assert refused == REFUSED
    assert all("mocap" in reasons[name] for name in REFUSED)


@pytest.mark.parametrize("angle", [0.2, 0.6])
def test_the_angle_of_a_heap_is_that_of_a_triangle_of_grains(angle):
    """Grains below the ledge are none of it."""
    along, up = np.meshgrid(*[(np.arange(100) + 0.5) / 100] * 2)
    above = np.column_stack((along[along + up < 1.0], np.tan(angle) * up[along + up < 1.0]))
    grains = np.concatenate((above, [(3.0, -1.0)] * 1000))
    scene = by_figure.heap(0)
    path = Trajectory(np.zeros(1), grains[None], *np.zeros((3, 1, len(grains), 2)))
    assert figures_of(scene, path)["angle of the heap, rad"] == pytest.approx(angle, rel=1e-6)


def test_a_column_on_a_ledge_touches_its_fixed_grains_and_one_wall():
    scene = by_figure.heap(3)
    places = {body.name: body.position for body in scene.bodies}
    fixed = {c.center_b for c in scene.contacts if c.name.startswith("ledge")}
    np.testing.assert_allclose(sorted(fixed), [(0.05 + 0.1 * k, -0.05) for k in range(9)], atol=1e-12)
    walls = [c for c in scene.contacts if c.type == "circle_on_line"]
    assert {(c.point_1, c.point_2) for c in walls} == {((0.0, 0.0), (0.0, -1.0))}
    assert all(np.array_equal(c.center_a, places[c.body_a]) for c in scene.contacts if c.name.startswith("ledge"))
    apart = [np.linalg.norm(np.subtract(a, b)) for a, b in itertools.combinations(places.values(), 2)]
    assert 0.1 < min(apart) < 0.11  # m: no two touch, and some are nearer than without a seed
    with pytest.raises(ValueError, match="ledge = 2 needs search = false and space = false"):
        scenes.make("granular_column", ledge=2, space=True)
    with pytest.raises(ValueError, match=r"spread = 0\.1 needs shape = 'round'"):
        scenes.make("granular_column", spread=0.1, shape="box", space=True, search=True)


@pytest.mark.slow
def test_heaps_of_other_starts_have_other_angles_within_their_spread():
    figures = by_figure._reference(by_figure.heap(0), 1e-4)
    angle, spread = figures["angle of the heap, rad"]
    settings = Settings(method="rk4", step=2.5e-5, events="none", estimate="off")
    other = by_figure.heap(100)
    assert abs(figures_of(other, simulate(other, settings))["angle of the heap, rad"] - angle) < spread < 0.5 * angle


@pytest.mark.parametrize("engine", ["mujoco", "exudyn", "drake"])
@pytest.mark.parametrize(("friction", "why"), [
    (RollingFriction(coefficient=0.7, lever=1e-3), "is given no resistance to rolling"),
    (StickSlip(coefficient=0.7, static=0.8, stiffness=1e5), "has one coefficient of friction"),
    (StickSlip(coefficient=0.7, static=0.7, stiffness=1e5), ""),
])  # fmt: skip
def test_friction_beyond_one_coefficient_is_refused(engine, friction, why):
    """The same scene runs with one coefficient; each of its contacts is named."""
    pytest.importorskip({"drake": "pydrake"}.get(engine, engine))
    model, scene = model_of(engine), scenes.make("bouncing_ball")
    ground = scene.contacts[0].model_copy(update={"friction": friction})
    refusal = model.engine.refusal(scene.model_copy(update={"contacts": (ground,)}), model.engine.methods()[0])
    assert refusal.startswith(f"contact {ground.name!r}: ") == bool(why)
    assert why in refusal
    assert bool(refusal) == bool(why)


def test_an_engine_elsewhere_is_started_once(monkeypatch, tmp_path):
    class There(Engine):
        def __init__(self, name, home, get):
            started.append(name)
            self.home = home

        def ask(self, *_):
            return ("way",)

    started: list[str] = []
    monkeypatch.setattr(contact, "Elsewhere", There)
    monkeypatch.setattr(contact.engines, "installed", lambda names: iter([There("registered", tmp_path, None)]))
    assert model_of("mujoco") is model_of("mujoco")
    assert own_engine("mujoco") is model_of("mujoco").engine
    assert started.count("mujoco") == 1


def test_engines_without_a_contact_model_refuse_and_ours_does_not(monkeypatch):
    scene = holding()["slope at 29% of the cone"]
    monkeypatch.setattr(contact.engines, "get", lambda name: Registered())
    assert own_engine("rebound").refusals(scene)[0].reason == "rebound has no contact model of its own"
    assert own_engine("mbs_ref").refusals(scene) == []
    assert Registered().refusals(scene) == []  # elsewhere it is as registered


class Registered(Engine):
    def refusals(self, scene):
        return []


@pytest.mark.slow
@pytest.mark.parametrize("method", ["euler_impratio100", "stock"])
def test_mujoco_runs_each_other_scene_to_its_end(method):
    pytest.importorskip("mujoco")
    others = {name: scene for name, scene in with_contact().items() if name not in REFUSED}
    paths = {name: run(model_of("mujoco"), method, scene, STEPS.get(name, 1e-3)) for name, scene in others.items()}
    assert {name: path for name, path in paths.items() if isinstance(path, str)} == {}


def test_a_sphere_on_the_side_of_a_moving_box_is_a_contact_of_mujoco():
    pytest.importorskip("mujoco")
    scene = scenes.make("ball_on_moving_seat", friction=0.0)
    path = run(model_of("mujoco"), "euler_impratio100", scene, 1e-4)
    ours = figures_of(scene, simulate(scene, Settings(rtol=1e-9, samples=2001)))
    theirs = figures_of(scene, path)
    assert [theirs[k] for k in ("penetration, m", "duration, s")] == pytest.approx(
        [ours[k] for k in ("penetration, m", "duration, s")], rel=0.02
    )


def test_figures_in_space_are_those_in_the_plane():
    settings = Settings(rtol=1e-10, samples=401)
    flat, space = (scenes.make(name) for name in ("bouncing_ball", "bouncing_sphere"))
    plane, solid = (figures_of(scene, simulate(scene, settings)) for scene in (flat, space))
    assert plane.keys() == solid.keys()
    assert list(solid.values()) == pytest.approx(list(plane.values()), rel=1e-6)


@pytest.mark.parametrize("name", ["rolling_disc", "rolling_sphere"])
def test_what_rolls_does_not_slip_and_does_not_stop(name):
    scene = scenes.make(name)
    figures = figures_of(scene, simulate(scene, Settings(rtol=1e-10, samples=101)))
    assert figures["static sink, m"] == pytest.approx(9.81 / 1e5, rel=1e-6)
    assert "stop distance, m" not in figures
