"""DASSL (SUNDIALS IDA) on four forms of the DAE; those beside the first show why indices are reduced."""

from functools import partial

from mbs_ref.integrators.loop.ida import PACKAGE, ida
from mbs_ref.integrators.loop.leg import Integrator
from mbs_ref.kernels.residual import GGL, INDEX_1, INDEX_2, INDEX_3

_integrator = partial(
    Integrator,
    kind="adaptive",
    order=5,
    varies_order=True,
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    source="Petzold 1982; Hindmarsh et al. 2005; Gear, Gupta, Leimkuhler 1985",
    package=PACKAGE,
    holds_deflections=False,
    cores=("planar", "spatial"),
    stabilizations=("none", "projection"),
)
INTEGRATORS = (
    _integrator(
        name="dassl",
        description="DASSL (SUNDIALS IDA) on the stabilised index-2 (GGL) form",
        advance=ida(GGL),
        needs_positions=True,
    ),
    _integrator(
        name="dassl_index1", description="DASSL (SUNDIALS IDA) on the index-1 form: drifts", advance=ida(INDEX_1)
    ),
    _integrator(
        name="dassl_index2",
        description="DASSL (SUNDIALS IDA) on the index-2 form, C_dot = 0: positions drift",
        advance=ida(INDEX_2),
        source="Petzold 1982; Hindmarsh et al. 2005; Brenan, Campbell, Petzold 1996, sec. 6.2",
    ),
    _integrator(
        name="dassl_index3",
        description="DASSL (SUNDIALS IDA) on the raw index-3 form: fails or is poor, and shows why indices are reduced",
        advance=ida(INDEX_3),
        stabilization="none",
        stabilizations=("none",),
        weakness="the error test and Newton's iteration of raw index 3 do not improve with the step",
        needs_positions=True,
    ),
)
