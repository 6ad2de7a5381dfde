"""DASSL (SUNDIALS IDA) on the index-2 form, C_dot = 0: positions drift."""

from mbs_ref.integrators.loop.ida import PACKAGE, ida
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.kernels.residual import INDEX_2

INTEGRATOR = Integrator(
    name="dassl_index2",
    kind="adaptive",
    order=5,
    varies_order=True,
    description="DASSL (SUNDIALS IDA) on the index-2 form, C_dot = 0: positions drift",
    advance=ida(INDEX_2),
    stabilizations=("none", "projection"),
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    source="Petzold 1982; Hindmarsh et al. 2005; Brenan, Campbell, Petzold 1996, sec. 6.2",
    package=PACKAGE,
    holds_deflections=False,
    cores=("planar", "spatial"),
)
