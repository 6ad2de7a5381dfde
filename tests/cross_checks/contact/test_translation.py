"""A requested contact is what an engine does: measured by a MuJoCo model and a time loop of the test's own."""

import re

import numpy as np
import pytest

from cross_checks.contact import model_of
from cross_checks.contact.by_figure import measured
from cross_checks.contact.request import Request, linear_law
from cross_checks.truths.of.bouncing import impact

SAME = 0.02  # of the requested figure
STEPS = 200  # of the free impact's half period


def random_request(seed: int) -> Request:
    """Return a request whose step resolves the contact."""
    dice = np.random.default_rng(seed)
    rebound, friction = dice.uniform(0.1, 0.95), dice.uniform(0.1, 1.0)
    stiffness, mass, speed = 10.0 ** dice.uniform((3, -1, -1), (6, 2, 1))
    step = np.pi * np.sqrt(mass / stiffness) / STEPS
    return Request(rebound, friction, float(stiffness), float(mass), float(speed), float(step))


def closed_form(request: Request, ratio: float) -> tuple[float, float, float]:
    """Return rebound, time until the surfaces part, and depth of m x'' = -k x - c x' >= 0, from samples."""
    omega = np.sqrt(request.stiffness / request.mass)
    poles = omega * (-ratio + np.sqrt(complex(ratio**2 - 1.0)) * np.array([1.0, -1.0]))
    t = np.linspace(0.0, 20.0 / omega, 400_001)
    wave = np.exp(np.outer(t, poles)) / (poles[0] - poles[1])
    x, v = (request.speed * (wave @ np.array([1.0, -1.0]))).real, (request.speed * (wave @ (poles * [1, -1]))).real
    end = int(np.argmax(request.stiffness * x + 2.0 * ratio * omega * request.mass * v < 0.0))
    return -v[end] / request.speed, t[end] - x[end] / v[end], x.max()


def own_mujoco(request: Request, snippet: str) -> tuple[float, float, float]:
    """Return rebound, duration (s) and depth (m) of a ball on a plane, with a snippet pasted into its model."""
    mujoco = pytest.importorskip("mujoco")
    pasted = re.sub(r"<!--.*?-->", "", snippet).replace("timestep=", 'gravity="0 0 0" timestep=')
    scene = f"""<mujoco>{pasted}<worldbody><geom name="A" type="plane" size="0 0 1"/>
      <body pos="0 0 1"><joint type="slide" axis="0 0 1"/>
      <geom name="B" type="sphere" size="0.05" mass="{request.mass!r}"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(scene)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = 5.3 * request.step * request.speed - 0.95, -request.speed
    gaps = [float(data.qpos[0]) + 0.95]
    while data.qvel[0] < 0.0 or gaps[-1] <= 0.0:
        assert len(gaps) < 100 * STEPS
        mujoco.mj_step(model, data)
        gaps.append(float(data.qpos[0]) + 0.95)
    after = float(data.qvel[0])
    touch, parting = gaps[0] / request.speed, (len(gaps) - 1) * request.step - gaps[-1] / after
    return after / request.speed, parting - touch, -min(gaps)


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 20))])
def test_mujoco_rebounds_lasts_and_sinks_as_requested(seed):
    pytest.importorskip("mujoco")
    request, model = random_request(seed), model_of("mujoco")
    requested = [request.figures[name] for name in ("restitution", "duration, s", "penetration, m")]
    ratio = request.law.damping / (2.0 * np.sqrt(request.stiffness * request.mass))
    assert closed_form(request, ratio) == pytest.approx(requested, rel=1e-3)
    assert own_mujoco(request, model.translate(request).snippet) == pytest.approx(requested, rel=SAME)


@pytest.mark.parametrize("engine", ["mujoco", "exudyn", pytest.param("drake", marks=pytest.mark.slow)])
@pytest.mark.parametrize("seed", [3, *(pytest.param(k, marks=pytest.mark.slow) for k in range(4, 8))])
def test_an_engine_obtains_what_it_does_not_refuse(engine, seed):
    pytest.importorskip({"drake": "pydrake"}.get(engine, engine))
    request, model = random_request(seed), model_of(engine)
    translation = model.translate(request)
    obtained = {one.figure: one.obtained for one in measured(model, request, translation)}
    can = [name for name in request.figures if name not in translation.refused]
    assert {"restitution", "duration, s", "penetration, m", "stop distance, m"} <= set(can)
    assert [obtained[name] for name in can] == pytest.approx([request.figures[name] for name in can], rel=SAME)
    stated = {name: refused.instead for name, refused in translation.refused.items()}
    assert {name: obtained[name] for name in stated} == pytest.approx(stated, rel=SAME)


def test_where_effective_masses_are_approximated_a_contact_is_as_soft(monkeypatch):
    """MJX has no others: in the plane MuJoCo's guess is 2/3 of the mobility, and creep and sink would be that of it."""
    pytest.importorskip("mujoco")
    from cross_checks.contact import mujoco_

    request, model = Request(0.5, 0.7, 1e4, 2.0), model_of("mujoco")
    exact = measured(model, request, model.translate(request))
    monkeypatch.setitem(mujoco_.OPTIONS, mujoco_.DEFAULT, mujoco_.OPTIONS[mujoco_.DEFAULT] | {"enableflags": 0})
    guessed = measured(model, request, model.translate(request))
    assert [one.obtained for one in guessed] == pytest.approx([one.obtained for one in exact], rel=1e-4)


def test_what_loses_nothing_loses_nothing_in_mujoco():
    pytest.importorskip("mujoco")
    request, model = Request(1.0, 0.0, 1e4, 1.0, step=1e-4), model_of("mujoco")
    (rebound, *_) = measured(model, request, model.translate(request))
    assert rebound.obtained == pytest.approx(1.0, abs=SAME)


@pytest.mark.parametrize("release", ["gap", "force"])
@pytest.mark.parametrize("rebound", [1e-3, 0.5, 0.999, 1.0])
def test_a_law_rebounds_as_named_by_either_rule_of_release(rebound, release):
    law = linear_law(rebound, 1e4, 2.0, release)
    assert impact(law, 2.0, 3.0).restitution == pytest.approx(rebound, rel=1e-9)
    assert law.release == release


@pytest.mark.parametrize(
    ("name", "value", "allowed"), [("rebound", 1.2, "to 1"), ("friction", -0.1, "at least 0"), ("mass", 0.0, "above 0")]
)
def test_a_request_that_no_contact_has_is_named(name, value, allowed):
    good = {"rebound": 0.5, "friction": 0.7, "stiffness": 1e5, "mass": 2.0}
    with pytest.raises(ValueError, match=rf"{name} = {value:g} is not allowed; it must be .*{allowed}"):
        Request(**good | {name: value})


def test_an_engine_without_a_contact_model_is_named():
    with pytest.raises(ValueError, match=r"engine = .rebound. .* allowed: mujoco"):
        model_of("rebound")
