"""DASSL (SUNDIALS IDA) on the stabilised index-2 (GGL) form."""

from mbs_ref.integrators.loop.ida import PACKAGE, ida
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.kernels.residual import GGL

INTEGRATOR = Integrator(
    name="dassl",
    kind="adaptive",
    order=5,
    varies_order=True,
    description="DASSL (SUNDIALS IDA) on the stabilised index-2 (GGL) form",
    advance=ida(GGL),
    stabilizations=("none", "projection"),
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    source="Petzold 1982; Hindmarsh et al. 2005; Gear, Gupta, Leimkuhler 1985",
    package=PACKAGE,
    holds_deflections=False,
    needs_positions=True,
    cores=("planar", "spatial"),
)
