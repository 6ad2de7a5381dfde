"""The classical Runge-Kutta method, order 4 (Kutta 1901; the papers' fixed-step method)."""

import numpy as np

from mbs_ref.integrators.loop.explicit import explicit
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.integrators.stages.tableau import Tableau, stability_polynomial

TABLEAU = Tableau(
    a=np.array([[0, 0, 0, 0], [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1.0, 0]]),
    b=np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
    c=np.array([0, 0.5, 0.5, 1.0]),
    error=np.zeros(0),
    error_low=np.zeros(0),
    order=4,
    error_order=0,
)
INTEGRATOR = Integrator(
    name="rk4",
    kind="fixed",
    order=4,
    description="classical Runge-Kutta, fixed step",
    advance=explicit(TABLEAU),
    stability=stability_polynomial(TABLEAU),
    ladder=(2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
)
