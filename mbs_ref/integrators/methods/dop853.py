"""DOP853: Dormand and Prince, order 8, with error estimates of order 5 and 3 and dense output of order 7."""

from mbs_ref.integrators.loop.explicit import explicit
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.integrators.stages.dop853_tableau import TABLEAU
from mbs_ref.integrators.stages.tableau import stability_polynomial

INTEGRATOR = Integrator(
    name="dop853",
    kind="both",
    order=8,
    embedded=7,  # its two estimates, made one, follow the eighth power of a step (Hairer, sec. II.10)
    description="Dormand-Prince of order 8, adaptive; fixed step when a step is given",
    advance=explicit(TABLEAU),
    interpolates=True,
    stability=stability_polynomial(TABLEAU),
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
)
