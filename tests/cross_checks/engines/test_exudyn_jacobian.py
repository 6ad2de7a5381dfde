"""The Jacobian that Exudyn gets of the shared force code, against central differences of the forces."""

from typing import Any

import numpy as np
import pytest

from cross_checks.engines import exudyn_
from mbs_ref import scenes
from mbs_ref.scene import Scene, SpatialBody, TorsionSpring
from mbs_ref.scene.contact import RegularisedCoulomb


def disc() -> Scene:
    """Return a disc 0.1 m above a rough line."""
    scene = scenes.make("oblique_disc")
    rough = scene.contacts[0].model_copy(update={"friction": RegularisedCoulomb(coefficient=0.2, speed=2.0)})
    return scene.model_copy(update={"contacts": (rough,)})


def tumbling() -> Scene:
    """Return two bodies in space with a damped torsion spring about an axis that no joint holds."""
    still: Any = {"mass": 2.0, "inertia": (0.1, 0.2, 0.3, 0.01, 0.0, 0.0)}
    bodies = SpatialBody(name="a", **still), SpatialBody(name="b", position=(1.0, 0.0, 0.0), **still)
    spring = TorsionSpring(name="s", body_a="a", body_b="b", stiffness=3.0, damping=0.5, axis=(0.0, 0.6, 0.8))
    return Scene(name="two", bodies=bodies, loads=(spring,))


@pytest.mark.parametrize(("scene", "sunk"), [(disc, 0.101), (tumbling, 0.0)])
def test_the_jacobian_of_shared_forces_is_their_derivative_in_both_levels(scene, sunk, monkeypatch):
    made: dict[str, Any] = {}
    real = exudyn_.item.ObjectGenericODE2
    monkeypatch.setattr(exudyn_.item, "ObjectGenericODE2", lambda **given: (made.update(given), real(**given))[1])
    exudyn_.build_redundant(scene(), "generalized_alpha")
    random, size = np.random.default_rng(5), len(made["forceVector"])
    q, v = 1e-4 * random.random(size), random.random(size)
    q[1] -= sunk
    forces, jacobian = made["forceUserFunction"], made["jacobianUserFunction"]
    for of_q, of_v in ((1.0, 0.0), (0.0, 1.0), (1.0, 400.0)):
        moves = 1e-6 / max(of_q, of_v) * np.eye(size)
        ends = [[forces(None, 0.0, 0, q + of_q * m, v + of_v * m) for m in (-move, move)] for move in moves]
        columns = [
            (np.array(after) - before) / (2.0 * move.max()) for (before, after), move in zip(ends, moves, strict=True)
        ]
        assert np.abs(columns).max() > 0.0
        found = jacobian(None, 0.0, 0, q, v, of_q, of_v)
        assert found == pytest.approx(-np.array(columns).T, abs=1e-5 * np.abs(columns).max())
