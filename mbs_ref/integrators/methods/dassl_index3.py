"""DASSL (SUNDIALS IDA) on the raw index-3 form: fails or is poor, and shows why indices are reduced."""

from mbs_ref.integrators.loop.ida import PACKAGE, ida
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.kernels.residual import INDEX_3

INTEGRATOR = Integrator(
    name="dassl_index3",
    kind="adaptive",
    order=5,
    varies_order=True,
    description="DASSL (SUNDIALS IDA) on the raw index-3 form: fails or is poor, and shows why indices are reduced",
    advance=ida(INDEX_3),
    stabilization="none",
    stabilizations=("none",),
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    source="Petzold 1982; Hindmarsh et al. 2005; Gear, Gupta, Leimkuhler 1985",
    weakness="the error test and Newton's iteration of raw index 3 do not improve with the step",
    package=PACKAGE,
    holds_deflections=False,
    needs_positions=True,
    cores=("planar", "spatial"),
)
