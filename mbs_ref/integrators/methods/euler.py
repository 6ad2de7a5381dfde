"""Explicit Euler, order 1 (the papers' simplest method)."""

import numpy as np

from mbs_ref.integrators.loop.explicit import explicit
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.integrators.stages.tableau import Tableau, stability_polynomial

TABLEAU = Tableau(np.zeros((1, 1)), np.ones(1), np.zeros(1), np.zeros(0), np.zeros(0), 1, 0)
INTEGRATOR = Integrator(
    name="euler",
    kind="fixed",
    order=1,
    description="explicit Euler",
    advance=explicit(TABLEAU),
    stability=stability_polynomial(TABLEAU),
    ladder=(4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4),
)
