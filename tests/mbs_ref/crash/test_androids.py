"""The androids of Fox 1999: mass properties, the two frames of the crash, energy, convergence, extremes."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.planar import PlanarSystem
from mbs_ref.crash import injury
from mbs_ref.crash.results import crash_results, sign_changes
from mbs_ref.observables import constraint_residual
from mbs_ref.scene import PlanarBody, PointBushing, Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

same_data = 1e-9  # kg, m, kg m^2: the data carry 15 digits
converged = 1e-6  # m
reference_digits = 0.01  # the reference peaks are given to 3 digits
NAMES = ("android_simplified", "android_vertebral")


def bare(name, **parameters):
    """Return the papers' model."""
    return scenes.make(name, model="paper", **parameters)


def run(scene, **settings):
    found = simulate(scene, Settings(**({"rtol": 1e-8, "samples": 401, "estimate": "off"} | settings)))
    assert found.ok, found.message
    return found


@pytest.fixture(scope="module")
def simplified():
    scene = bare("android_simplified")
    return scene, run(scene, samples=2001)


def aggregate(scene):
    """Mass, centre of mass and inertia about it of all but the seat."""
    bodies = [b for b in scene.bodies if not b.name.startswith("seat")]
    mass = np.array([b.mass for b in bodies])
    place = np.array([b.position for b in bodies])
    centre = mass @ place / mass.sum()
    return mass.sum(), *centre, sum(b.inertia for b in bodies) + mass @ np.sum((place - centre) ** 2, axis=1)


def test_simplified_is_the_aggregation_of_vertebral():
    one, other = (aggregate(bare(name)) for name in NAMES)
    assert one == pytest.approx(other, abs=same_data)
    assert one[0] == pytest.approx(75.0)
    assert one[3] == pytest.approx(8.048911, abs=1e-6)


@pytest.mark.parametrize(("name", "bodies", "rows"), [(NAMES[0], 13, 26), (NAMES[1], 48, 96)])
def test_counts(name, bodies, rows):
    for seat in ("fixed", "driven"):
        system = PlanarSystem(bare(name, seat=seat))
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
    fixed, driven = (bare("android_simplified", impact=impact, seat=seat) for seat in ("fixed", "driven"))
    one, other = run(fixed), run(driven)
    seat = fixed.body_index("seat_base")
    relative = other.position - other.position[:, [seat]]
    assert np.abs(relative - one.position + one.position[:, [seat]]).max() < 1e-8


@pytest.mark.parametrize("impact", ["front", "rear"])
def test_two_unlike_integrators_agree(impact):
    scene = bare("android_simplified", impact=impact)
    explicit, implicit = run(scene), run(scene, method="radau")
    assert np.abs(explicit.position - implicit.position).max() < converged
    assert np.abs(constraint_residual(scene, explicit)).max() < 1e-9


def test_vertebral_converges():
    scene = bare("android_vertebral")
    fine, coarse = run(scene, samples=41), run(scene, samples=41, rtol=1e-6)
    assert np.abs(fine.position - coarse.position).max() < converged
    assert np.abs(constraint_residual(scene, fine)).max() < 1e-9


def test_whiplash_changes_the_sign_of_the_cervical_torques():
    """In a frontal impact every cervical joint is flexed first and extended after about 0.1 s, C1 to C6."""
    scene = bare("android_vertebral")
    path = run(scene, samples=201)
    torques = crash_results(scene, path).cervical_torques
    assert list(torques) == ["C1", "C2", "C3", "C4", "C5", "C6"]
    for torque in torques.values():
        assert torque.max() > 50.0
        assert torque.min() < -20.0
        assert sign_changes(path.times, torque) == pytest.approx([0.1], abs=0.01)


def test_injury_measures_of_both_levels():
    """The neck's moment takes part in Nij; a chest that gives way has a viscous criterion, a rigid one has none."""
    simple, detailed = (crash_results(scene, run(scene, samples=201)) for scene in (bare(name) for name in NAMES))
    for found in (simple, detailed):
        axial = injury.nij(found.neck_axial, np.zeros_like(found.neck_axial))
        bent = injury.nij(found.neck_axial, found.neck_moment)
        assert found.measures["Nij"] == pytest.approx(bent.max())
        assert found.measures["Nij"] > axial.max()
        assert found.measures["TTI at 45 years, g"] > 1.4 * 45.0
    assert simple.chest_deflection is None
    assert "VC, m/s" not in simple.measures
    assert detailed.measures["chest deflection, m"] > 0.0
    assert detailed.measures["VC, m/s"] > 0.0  # its scale, and Nij's, stand in test_against_injury_vectors.py


def test_a_bushing_takes_nothing_from_a_rigid_rotation():
    """Its damper sees the slip at body b's mark, where both forces act: none where all turn as one."""
    bodies = tuple(PlanarBody(name=n, mass=1.0, inertia=1.0, position=(x, 0.0)) for n, x in (("a", 0.0), ("b", 1.0)))
    bush = PointBushing(name="bush", body_a="a", body_b="b", point=(0.5, 0.0), stiffness=0.0, damping=3.0)
    system = PlanarSystem(Scene(name="pair", bodies=bodies, loads=(bush,), gravity=(0.0, 0.0)))
    q = np.array([[0.0, 0.0, 0.3], [1.2, 0.4, -0.2]])  # the marks apart
    spin = 2.0
    v = np.array([[-spin * y, spin * x, spin] for x, y, _ in q])
    assert np.abs(system.applied_forces(0.0, np.concatenate((q, v), axis=None))).max() < 1e-14


def test_pulse_table_keeps_the_impulse():
    smooth, table = (run(bare("android_simplified", pulse=kind)) for kind in ("half_sine", "table"))
    assert np.abs(smooth.position - table.position).max() < 1e-3


def test_extremes_are_errors_or_stated():
    with pytest.raises(ValueError, match="belt_stiffness = -1"):
        bare("android_simplified", belt_stiffness=-1.0)
    assert "floats 0.01 m above its seat" in bare("android_simplified", lift=0.01).description
    late = bare("android_simplified", peak_force=5000.0)
    assert "ends after the run" in late.description
    run(bare("android_simplified", lift=0.01))
    run(bare("android_simplified", law="spring_damper", belts=False))
