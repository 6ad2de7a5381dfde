"""The standard atmosphere against the printed tables, in both of its writings: the kernel's and the truth's.

U.S. Standard Atmosphere, 1976 (NOAA-S/T 76-1562, NASA-TM-X-74335), table I, by geometric altitude.
"""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.made_by.sky.satellites import NoAirError
from cross_checks.truths.made_by.sky.satellites import standard_density as of_the_truth
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.kernels.particles.satellites import BASE, PRESSURE, standard_density
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status

DENSITIES = {  # m: kg/m^3, as printed
    0: "1.2250e+00", 5_000: "7.3643e-01", 10_000: "4.1351e-01", 15_000: "1.9476e-01", 20_000: "8.8910e-02",
    25_000: "4.0084e-02", 30_000: "1.8410e-02", 40_000: "3.9957e-03", 50_000: "1.0269e-03", 60_000: "3.0968e-04",
    70_000: "8.2829e-05", 80_000: "1.8458e-05", 86_000: "6.958e-06",
}  # fmt: skip
BASE_PRESSURES = (101_325.0, 22_632.06, 5474.889, 868.0187, 110.9063, 66.93887, 3.956420)  # Pa, at the layers' bases
EVERYWHERE = np.linspace(-5000.0, 86_000.0, 401)  # m


@pytest.mark.parametrize("altitude", DENSITIES)
def test_both_writings_print_the_table(altitude):
    printed = DENSITIES[altitude]
    decimals = len(printed.split("e")[0]) - 2
    assert f"{standard_density(float(altitude)):.{decimals}e}" == printed
    assert f"{float(of_the_truth(np.longdouble(altitude))):.{decimals}e}" == printed


def test_the_layers_begin_at_the_published_pressures():
    assert pytest.approx(BASE_PRESSURES, rel=1e-6) == PRESSURE
    assert len(BASE) == len(PRESSURE)


def test_both_writings_agree_between_the_tables_ends():
    kernel = np.array([standard_density(float(z)) for z in EVERYWHERE])
    truth = of_the_truth(EVERYWHERE.astype(np.longdouble)).astype(float)
    np.testing.assert_allclose(kernel, truth, rtol=2e-14, atol=0.0)


def test_the_air_bears_its_own_weight():
    """dp = -rho g dz: what lies between two altitudes is what the pressures differ by, in extended precision."""
    base = 6_356_766.0 * BASE / (6_356_766.0 - BASE)  # m, geometric
    for k in range(len(base) - 1):
        points, weights = np.polynomial.legendre.leggauss(40)
        z = (base[k] + base[k + 1]) / 2 + points * (base[k + 1] - base[k]) / 2
        gravity = 9.80665 * (6_356_766.0 / (6_356_766.0 + z)) ** 2
        weight = np.sum(weights * of_the_truth(z.astype(np.longdouble)) * gravity) * (base[k + 1] - base[k]) / 2
        assert float(weight) == pytest.approx(PRESSURE[k] - PRESSURE[k + 1], rel=1e-12)


@pytest.mark.parametrize("altitude", [-5001.0, 86_001.0])
def test_no_air_is_made_up_beyond_the_tables(altitude):
    assert np.isnan(standard_density(altitude))
    with pytest.raises(NoAirError, match="-5 and 86 km"):
        of_the_truth(np.longdouble(altitude))


def test_a_body_that_leaves_the_air_ends_its_run_and_has_no_truth():
    scene, times = scenes.make("nesc_sphere_in_air"), np.array([0.0, 40.0, 120.0])
    run = simulate(scene, Settings(method="dop853", rtol=1e-10, estimate="off"), times)
    assert run.status is Status.NON_FINITE
    assert run.times[-1] == 40.0
    truth = seek_truth(scene, times)
    assert isinstance(truth, NoTruth)
    assert "the standard atmosphere ends" in truth.reason
