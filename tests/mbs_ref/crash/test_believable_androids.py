"""Joint stops, body contacts and head restraints: androids that do not pass through themselves or their seat."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.crash.outlines import Places, excesses, read_data
from mbs_ref.crash.results import crash_results
from mbs_ref.crash.stops import STOP, bounds, joint_stops, stop_load
from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import PlanarBody, Revolute, Scene, Torque
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

two_centimetres = 0.02  # m, beyond what cushion, sole and flesh are declared to give way by
NAMES = ("android_simplified", "android_vertebral")
BARE = {"model": "paper"}


def run(name: str, **parameters):
    scene = scenes.make(name, **parameters)
    path = simulate(scene, Settings(rtol=1e-7, samples=201, estimate="off"))
    assert path.ok, path.message
    return scene, path


def deepest(name: str, **parameters) -> tuple[str, float]:
    found = {pair: float(depth.max()) for pair, depth in excesses(Motion(*run(name, **parameters))).items()}
    return max(found.items(), key=lambda entry: entry[1])


LARGE = pytest.param(NAMES[1], marks=pytest.mark.slow)


@pytest.mark.parametrize("impact", ["front", "rear"])
@pytest.mark.parametrize("name", [NAMES[0], LARGE])
def test_nothing_passes_through_anything(name, impact):
    scene, path = run(name, impact=impact)
    assert max(depth.max() for depth in excesses(Motion(scene, path)).values()) < two_centimetres
    soft = read_data("believable")["depths"]
    for contact in scene.contacts:
        where = "floor" if contact.body_b == "ground" else contact.body_b if contact.body_b in soft else contact.body_a
        depth = path.contacts[contact.name][:, 0].max()
        assert depth < soft.get(where, soft["flesh"]) + two_centimetres, contact.name


@pytest.mark.parametrize(
    ("name", "impact", "pair"),
    [(NAMES[0], "rear", "hand in seat_back"), pytest.param(NAMES[1], "front", "head in thigh", marks=pytest.mark.slow)],
)
def test_the_bare_models_pass_through_seat_and_thighs(name, impact, pair):
    """So a check that sees nothing here would see nothing there."""
    where, depth = deepest(name, impact=impact, **BARE)
    assert where == pair
    assert depth > 5.0 * two_centimetres


def test_the_papers_model_is_the_believable_one_with_less():
    without = {"slack": 0.0, "belt_limit": 0.0, "toe_board": False, "head_restraint": "integral"}
    for name in NAMES:
        bare, full = scenes.make(name, **BARE), scenes.make(name, **without)
        assert not any(load.name.startswith(STOP) for load in bare.loads)
        shared = [load for load in full.loads[: len(bare.loads)] if not load.name.startswith("belt.thorax")]
        assert shared == [load for load in bare.loads if not load.name.startswith("belt.thorax")]
        belts = [sum(x.stiffness for x in s.loads if x.name.startswith("belt.thorax")) for s in (bare, full)]
        assert belts[0] == pytest.approx(belts[1])
        assert bare.contacts == full.contacts[: len(bare.contacts)]
        for slack in (0.05, scenes.describe(name).parameters["slack"]):
            with pytest.raises(ValueError, match=rf"slack = {slack} does not go with model = 'paper'"):
                scenes.make(name, slack=slack, **BARE)
        assert scenes.make(name, **bare.parameters) == bare


@pytest.mark.parametrize("name", [*NAMES, "android_spatial"])
def test_a_reel_pays_out_webbing_of_the_shoulder_belt_alone(name):
    plain, reeled = ({x.name: x for x in scenes.make(name, **given).loads} for given in ({}, {"retractor": 0.05}))
    for key, belt in plain.items():
        if key.startswith("belt."):
            longer = 0.05 if key.startswith("belt.thorax") else 0.0
            assert reeled[key] == belt.model_copy(update={"rest_length": belt.rest_length + longer})


@pytest.mark.parametrize("torque", [60.0, -60.0])
def test_a_stop_holds_a_known_torque_at_its_limit(torque):
    """A forearm turned by a steady torque comes to rest where the stop's stiffness, and its joint's, say."""
    data, stops = read_data(NAMES[0]), read_data("believable")["stops"]
    places = Places(data, 0.0)
    joint = next(j for j in data["joints"] if j["body_i"] == "upper_arm")
    strings = tuple(joint_stops([joint], stops, places))
    low, high = bounds(joint, next(e for e in stops["ranges"] if e["joint"] == "upper_arm-lower_arm"), places)
    assert (math.degrees(low), math.degrees(high)) == pytest.approx((-45.0, 105.0))
    hinge = places.point("upper_arm", "elbow")
    bodies = tuple(
        PlanarBody(name=n, mass=1.0, inertia=0.02, position=places.pose(n)[0], angle=places.pose(n)[1])
        for n in ("upper_arm", "lower_arm")
    )
    pins = (
        Revolute(name="hold", body_a="ground", body_b="upper_arm", point=hinge),
        Revolute(name="elbow", body_a="upper_arm", body_b="lower_arm", point=hinge),
    )
    tied = Torque(name="back", body="upper_arm", torque=-torque)
    turned = Torque(name="on", body="lower_arm", torque=torque)
    scene = Scene(name="elbow", bodies=bodies, joints=pins, loads=(*strings, tied, turned))
    damped = tuple(s.model_copy(update={"damping": 20.0 * s.damping}) for s in strings)
    path = simulate(scene.model_copy(update={"loads": (*damped, tied, turned)}), Settings(t_end=3.0, samples=31))
    assert path.ok, path.message
    turn = path.orientation[-1, 1] - path.orientation[-1, 0] - (bodies[1].angle - bodies[0].angle)
    limit = high if torque > 0.0 else low
    stiffness = stops["stiffness_factor"] * joint["torsion_k"]  # N m/rad where it sets in
    assert turn - limit == pytest.approx(torque / stiffness, rel=0.1)
    _, moment = stop_load(Motion(scene, path), hinge, "lower_arm", "upper_arm")
    assert moment[-1] == pytest.approx(-torque, rel=1e-3)


def test_a_head_without_restraint_is_whipped_back_and_a_near_one_prevents_it():
    """The neck bends back by half a turn more than half a right angle, and the moment at its top with it."""
    turn, moment = {}, {}
    for restraint in ("integral", "separate", "none"):
        scene, path = run(NAMES[0], impact="rear", head_restraint=restraint)
        bend = path.orientation[:, scene.body_index("head")] - path.orientation[:, scene.body_index("thorax")]
        turn[restraint] = math.degrees(bend.max() - bend[0])
        moment[restraint] = crash_results(scene, path).neck_moment.min()
    assert turn["integral"] < 15.0 < turn["separate"] < 30.0 < 45.0 < turn["none"]
    assert moment["none"] < 3.0 * moment["separate"] < 0.0


def test_energy_balances_with_stops_and_contacts():
    scene = scenes.make(NAMES[0])
    found = crash_results(scene, simulate(scene, Settings(rtol=1e-8, samples=401, estimate="off")))
    drift = found.energy - found.energy[0] - sum(found.works.values())
    assert np.max(np.abs(drift)) < 1e-3 * np.max(np.abs(found.works["pulse"]))
    assert found.works["joint stops"][-1] < 0.0
