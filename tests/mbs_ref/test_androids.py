"""The androids of Fox 1999: mass properties, the two frames of the crash, energy, convergence, extremes."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.crash_results import crash_results
from mbs_ref.observables import constraint_residual
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.springs import twist_of
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

same_data = 1e-9  # kg, m, kg m^2: the data carry 15 digits
converged = 1e-6  # m
reference_digits = 0.01  # the reference peaks are given to 3 digits
one_newton_metre = 1.0  # N m: below, a torque has no sign worth the name
NAMES = ("android_simplified", "android_vertebral")


def run(scene, **settings):
    found = simulate(scene, Settings(**({"rtol": 1e-8, "samples": 401} | settings)))
    assert found.ok, found.message
    return found


@pytest.fixture(scope="module")
def simplified():
    scene = scenes.make("android_simplified")
    return scene, run(scene, samples=2001)


def aggregate(scene):
    """Mass, centre of mass and inertia about it of all but the seat."""
    bodies = [b for b in scene.bodies if not b.name.startswith("seat")]
    mass = np.array([b.mass for b in bodies])
    place = np.array([b.position for b in bodies])
    centre = mass @ place / mass.sum()
    return mass.sum(), *centre, sum(b.inertia for b in bodies) + mass @ np.sum((place - centre) ** 2, axis=1)


def test_simplified_is_the_aggregation_of_vertebral():
    one, other = (aggregate(scenes.make(name)) for name in NAMES)
    assert one == pytest.approx(other, abs=same_data)
    assert one[0] == pytest.approx(75.0)
    assert one[3] == pytest.approx(8.048911, abs=1e-6)


@pytest.mark.parametrize(("name", "bodies", "rows"), [(NAMES[0], 13, 26), (NAMES[1], 48, 96)])
def test_counts(name, bodies, rows):
    from mbs_ref.planar_system import PlanarSystem

    for seat in ("fixed", "driven"):
        system = PlanarSystem(scenes.make(name, seat=seat))
        assert (system.n_bodies, system.n_constraints) == (bodies, rows)


def test_reference_peaks(simplified):
    found = crash_results(*simplified)
    assert found.seat_force.max() == pytest.approx(9900.0, rel=reference_digits)
    assert found.belt_force.max() == pytest.approx(16600.0, rel=reference_digits)
    assert found.measures["head peak before 120 ms, g"] == pytest.approx(28.4, rel=reference_digits)
    assert found.head_excursion[:, 0].max() == pytest.approx(0.316, rel=reference_digits)


def test_energy_balance(simplified):
    found = crash_results(*simplified)
    drift = found.energy - found.energy[0] - sum(found.works.values())
    assert np.max(np.abs(drift)) < 1e-3 * np.max(np.abs(found.works["pulse"]))
    assert all(found.works[name].min() >= found.works[name][-1] - 1.0 for name in ("belts", "joint dampers"))


@pytest.mark.parametrize("impact", ["front", "rear"])
def test_driven_seat_and_crash_forces_agree(impact):
    fixed, driven = (scenes.make("android_simplified", impact=impact, seat=seat) for seat in ("fixed", "driven"))
    one, other = run(fixed), run(driven)
    seat = fixed.body_index("seat_base")
    relative = other.position - other.position[:, [seat]]
    assert np.abs(relative - one.position + one.position[:, [seat]]).max() < 1e-8


@pytest.mark.parametrize("impact", ["front", "rear"])
def test_two_unlike_integrators_agree(impact):
    scene = scenes.make("android_simplified", impact=impact)
    explicit, implicit = run(scene), run(scene, method="radau")
    assert np.abs(explicit.position - implicit.position).max() < converged
    assert np.abs(constraint_residual(scene, explicit)).max() < 1e-9


def test_vertebral_converges():
    scene = scenes.make("android_vertebral")
    fine, coarse = run(scene, samples=41), run(scene, samples=41, rtol=1e-6)
    assert np.abs(fine.position - coarse.position).max() < converged
    assert np.abs(constraint_residual(scene, fine)).max() < 1e-9


def test_whiplash_changes_the_sign_of_the_cervical_torques():
    """In a frontal impact every cervical joint is flexed first and extended after about 0.1 s, T1 to C1."""
    scene = scenes.make("android_vertebral")
    motion = Motion(scene, run(scene, samples=201))
    for vertebra in ("C1", "C2", "C3", "C4", "C5", "C6"):
        spring = next(x for x in scene.loads if x.name.endswith(".restoring") and x.body_a == vertebra)
        twist, rate = twist_of(motion, spring)
        torque = -spring.stiffness * twist - spring.damping * rate
        loaded = np.abs(torque) > one_newton_metre
        change = motion.times[loaded][1:][np.diff(np.sign(torque[loaded])) != 0.0]
        assert torque.min() < -50.0
        assert torque.max() > 20.0
        assert change == pytest.approx([0.1], abs=0.01)


def test_pulse_table_keeps_the_impulse():
    smooth, table = (run(scenes.make("android_simplified", pulse=kind)) for kind in ("half_sine", "table"))
    assert np.abs(smooth.position - table.position).max() < 1e-3


def test_extremes_are_errors_or_stated():
    with pytest.raises(ValueError, match="belt_stiffness = -1"):
        scenes.make("android_simplified", belt_stiffness=-1.0)
    assert "floats 0.01 m above its seat" in scenes.make("android_simplified", lift=0.01).description
    late = scenes.make("android_simplified", peak_force=5000.0)
    assert "ends after the run" in late.description
    run(scenes.make("android_simplified", lift=0.01))
    run(scenes.make("android_simplified", law="spring_damper", belts=False))
