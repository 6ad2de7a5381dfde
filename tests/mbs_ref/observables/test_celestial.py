"""Energy and momentum of particles that attract each other, by hand on made-up places and velocities."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref.observables import celestial
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.celestial import Newton
from mbs_ref.trajectory import Trajectory

G = 2.0  # m^3/(kg s^2), of a made-up world
MASS = np.array([7.0, 0.5, 3.0])  # kg; the last attracts nothing
TIMES = np.array([0.0, 1.0, 2.0])


def world(light: float, said: float = 1.0) -> tuple[Scene, Trajectory]:
    """Return three bodies, `light` times G m of the last of them, and where they are said to be at three times.

    The mass that the scene says of the second is `said` times what its gm tells.
    """
    random = np.random.default_rng(3)
    x, v = random.normal(size=(2, 3, 3, 3))
    bodies = tuple(
        PointMass(name=f"b{k}", mass=mass, position=tuple(x[0, k]), velocity=tuple(v[0, k]))
        for k, mass in enumerate((MASS * [1.0, said, 1.0]).tolist())
    )
    newton = Newton(name="newton", gm=tuple((G * MASS * [1.0, 1.0, light]).tolist()))
    turn = np.tile([1.0, 0.0, 0.0, 0.0], (3, 3, 1))
    scene = Scene(name="world", gravity=(0.0, 0.0, 0.0), bodies=bodies, loads=(newton,))
    return scene, Trajectory(TIMES, x, turn, v, np.zeros((3, 3, 3)))


@pytest.mark.parametrize(("light", "said"), [(0.0, 1.0), (1.0, 1.0), (1.0, 10.0)])
def test_energy_counts_every_pair_once_with_masses_by_gm_and_a_test_particle_with_its_own(light, said):
    scene, path = world(light, said)
    wanted = 0.5 * np.sum(MASS * np.sum(path.velocity**2, axis=2), axis=1)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        wanted -= G * MASS[i] * MASS[j] / np.linalg.norm(path.position[:, i] - path.position[:, j], axis=1)
    np.testing.assert_allclose(celestial.energy(scene, path).astype(float), wanted, rtol=1e-14)
    np.testing.assert_allclose(celestial.drift(scene, path), wanted - wanted[0], rtol=1e-12, atol=1e-13)


def test_momentum_drifts_from_its_first_value_and_is_not_kept_where_one_attracts_and_is_not_attracted():
    scene, path = world(1.0)
    linear = np.einsum("k,tkd->td", MASS, path.velocity)
    angular = np.einsum("k,tkd->td", MASS, np.cross(path.position, path.velocity))
    wanted = [max(np.abs(part[k] - part[0]).max() for part in (linear, angular)) for k in range(3)]
    assert wanted[0] == 0.0
    np.testing.assert_allclose(celestial.momentum_drift(scene, path), wanted, rtol=1e-13)
    assert celestial.momentum_drift(*world(0.0)) is None
