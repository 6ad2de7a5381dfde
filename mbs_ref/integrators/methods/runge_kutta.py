"""Explicit Runge-Kutta methods, DOP853 with its error estimates and dense output among them."""

from mbs_ref.integrators.loop.explicit import explicit
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.integrators.stages.tableau import DOP853, EULER, RK4, Tableau, stability_polynomial


def _integrator(tableau: Tableau, **facts) -> Integrator:
    return Integrator(order=tableau.order, advance=explicit(tableau), stability=stability_polynomial(tableau), **facts)


dop853 = _integrator(
    DOP853,
    name="dop853",
    kind="both",
    embedded=7,  # its two estimates, combined, follow the eighth power of a step (Hairer, sec. II.10)
    description="Dormand-Prince of order 8, adaptive; fixed step when a step is given",
    interpolates=True,
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
)
euler = _integrator(
    EULER, name="euler", kind="fixed", description="explicit Euler", ladder=(4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)
)
rk4 = _integrator(
    RK4,
    name="rk4",
    kind="fixed",
    description="classical Runge-Kutta, fixed step",
    ladder=(2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3, 6.25e-4),
)
