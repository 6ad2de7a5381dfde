"""The uncontrolled bicycle against Meijaard, Papadopoulos, Ruina and Schwab, Proc. R. Soc. A 463 (2007) 1955-1982."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import observables, scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.linearised import steady_motion_at_start
from mbs_ref.trajectory import Status

PRINTED = 1e-11  # 1/s, the bound; the table has 14 decimals
# Table 2: speed (m/s), real and imaginary part of weave (or both of its real parts at 0), capsize, castering, 1/s
PUBLISHED = (
    (0, (5.53094371765393, 0.0), 3.13164324790656, -3.13164324790656, -5.53094371765393),
    (1, (3.52696170990070, 0.80774027519930), -3.13423125066578, -7.11008014637442),
    (2, (2.68234517512745, 1.68066296590675), -3.07158645641514, -8.67387984831735),
    (3, (1.70675605663975, 2.31582447384325), -2.63366137253667, -10.35101467245920),
    (4, (0.41325331521125, 3.07910818603206), -1.42944427361326, -12.15861426576447),
    (5, (-0.77534188219585, 4.46486771378823), -0.32286642900409, -14.07838969279822),
    (6, (-1.52644486584142, 5.87673060598709), -0.00406690076970, -16.08537123098026),
    (7, (-2.13875644258362, 7.19525913329805), 0.10268170574766, -18.15788466125262),
    (8, (-2.69348683581097, 8.46037971396931), 0.14327879765713, -20.27940894394569),
    (9, (-3.21675402252485, 9.69377351531791), 0.15790184030917, -22.43788559040858),
    (10, (-3.72016840437287, 10.90681139476287), 0.16105338653172, -24.62459635017404),
)
# eq 5.3: M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 of lean and steer
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
C1 = np.array([[0.0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0.0, 76.59734589573222], [0.0, 2.65431523794604]])


def modes(speed: float) -> np.ndarray:
    return steady_motion_at_start(scenes.make("bicycle", speed=speed, roll_rate=0.0)).eigenvalues


def gaps(expected, found: np.ndarray) -> list[float]:
    return [float(np.abs(found - value).min()) for value in expected]


@pytest.mark.parametrize(("speed", "weave", "rest"), [(row[0], row[1], row[2:]) for row in PUBLISHED])
def test_eigenvalues_are_the_published_ones(speed, weave, rest):
    found = modes(speed)
    expected = [complex(*weave), complex(*weave).conjugate(), *rest]
    assert max(gaps(expected, found)) < PRINTED
    assert np.count_nonzero(found) == 4  # where it is, which way it goes, how fast, how far its wheels turned: nothing
    assert len(found) == 10  # seven freedoms of places, three of rates: four rows act on velocities alone


@pytest.mark.parametrize("speed", [0.7, 4.29238253634111, 5.5, 6.02426201538837])
def test_eigenvalues_are_those_of_the_linear_equations(speed):
    below = [-np.linalg.solve(M, 9.81 * K0 + speed**2 * K2), -np.linalg.solve(M, speed * C1)]
    linear = np.block([[np.zeros((2, 2)), np.eye(2)], below])
    assert max(gaps(np.linalg.eigvals(linear), modes(speed))) < PRINTED


def test_it_is_stable_between_the_weave_and_the_capsize_speed():
    assert modes(4.29).real.max() > 1e-4
    assert modes(4.30).real.max() == 0.0
    assert modes(6.02).real.max() == 0.0
    assert modes(6.03).real.max() > 1e-5


def test_the_run_of_the_paper_keeps_its_energy_and_rights_itself():
    """Fig. 4: at 4.6 m/s, rolled over at 0.5 rad/s, it weaves and comes upright; the roll's energy is speed then."""
    scene = scenes.make("bicycle")
    path = simulate(scene, Settings(rtol=1e-11, samples=101, estimate="off"))
    assert path.status is Status.SUCCESS
    drift = observables.energy_balance(scene, path).drift
    assert drift is not None
    assert np.abs(drift).max() < 1e-8  # J of 1000
    assert np.abs(observables.constraint_residual(scene, path)).max() < 1e-12
    assert np.abs(observables.constraint_rate(scene, path)).max() < 1e-11  # no slip
    roll, rates = path.angular_velocity[:, 1, 0], path.velocity[:, 0]
    assert np.abs(roll[-1]) < 0.05 < 0.5 == roll[0]
    rolling_mass = 94.0 + 0.12 / 0.3**2 + 0.28 / 0.35**2  # kg, the wheels' turning included
    faster = np.sqrt(4.6**2 + M[0, 0] * 0.5**2 / rolling_mass)
    assert np.hypot(rates[-1, 0], rates[-1, 1]) == pytest.approx(faster, abs=1e-3)


def test_another_formulation_runs_the_same():
    scene = scenes.make("bicycle")
    settings = Settings(rtol=1e-9, t_end=0.5, samples=6)
    ends = [simulate(scene, settings.model_copy(update={"method": name})) for name in ("dop853", "dassl_index2")]
    assert all(path.ok for path in ends)
    assert np.abs(ends[0].position - ends[1].position).max() < 1e-6


@pytest.mark.parametrize("method", ["generalized_alpha", "dassl", "dassl_index3"])
def test_methods_that_ask_for_positions_say_why_they_refuse(method):
    step = {"step": 1e-3} if method == "generalized_alpha" else {}
    with pytest.raises(ValueError, match="a rolling wheel has constraints on velocities"):
        simulate(scenes.make("bicycle"), Settings(method=method, **step))
