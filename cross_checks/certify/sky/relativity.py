"""First post-Newtonian gravity, of all bodies or of the first alone."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.sky.gravity import newton, separations
from cross_checks.certify.sky.numbers import Field, dot, masses, norm, real
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import Newton, Relativity

BETA = GAMMA = 1  # general relativity's


def post_newtonian(scene: Scene, load: Relativity) -> Field:
    """Return what relativity adds to Newton's attraction."""
    return _all_bodies(scene, load) if load.form == "eih" else _first_body(scene, load)


def _all_bodies(scene: Scene, load: Relativity) -> Field:
    """The point-mass equation of Newhall, Standish and Williams, Astron. Astrophys. 125 (1983) 150, eq 1.

    Its accelerations a_j are Newton's, which is all that matters to this order.
    """
    gm, c2 = masses(scene), real(load.c) ** 2
    attraction = newton(scene, Newton(name="newton", gm=tuple(float(m) for m in gm[:, 0])))

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        apart, r = separations(x)  # r_j - r_i
        potential = np.sum(gm / r, axis=2)  # at every body, of all others
        a = attraction(t, x, v)
        vi, vj, aj = v[:, :, None], v[:, None], a[:, None]
        toward = dot(apart, vj)
        brackets = (
            (-2 * (BETA + GAMMA) * potential + GAMMA * dot(v, v))[:, :, None]
            + (-(2 * BETA - 1) * potential + (1 + GAMMA) * dot(v, v))[:, None]
            - 2 * (1 + GAMMA) * dot(vi, vj)
            - (toward / r) ** 2 * 3 / 2
            + dot(apart, aj) / 2
        )
        moving = -(2 + 2 * GAMMA) * dot(apart, vi) + (1 + 2 * GAMMA) * toward
        terms = gm / r**3 * (apart * brackets + moving * (vi - vj)) + (3 + 4 * GAMMA) * gm / (2 * r) * aj
        return np.sum(terms, axis=2) / c2

    return field


def _first_body(scene: Scene, load: Relativity) -> Field:
    """The Schwarzschild terms of IERS Conventions 2010, eq 10.12, without a reaction."""
    gm, c2 = masses(scene)[0], real(load.c) ** 2

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        r, rate = x[:, 1:] - x[:, :1], v[:, 1:] - v[:, :1]
        distance = norm(r)
        static = (2 * (BETA + GAMMA) * gm / distance - GAMMA * dot(rate, rate)) * r
        moving = 2 * (1 + GAMMA) * dot(r, rate) * rate
        pull = np.zeros_like(x)
        pull[:, 1:] = gm / (c2 * distance**3) * (static + moving)
        return pull

    return field
