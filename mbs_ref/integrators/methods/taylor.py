"""Taylor series of variable order for small planar trees, whose derivatives follow by recurrences.

The step makes the last terms as large as the tolerance: A. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99,
sec. 3. Their order counts the p^2 products of a step alone; what a step and an order cost besides makes a higher order
cheaper. No step is rejected. Outputs and events are values of the step's polynomial, so that neither shortens a step
nor costs an expansion. The state is that of relative coordinates, in which joints are always closed.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from mbs_ref.cores.series import MAX_ORDER, expansion_of, no_series
from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop.series import advance_taylor

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

MIN_ORDER = 4
PER_STEP, PER_ORDER = 150, 30  # products that cost as much as a step and an order do besides, measured on chains


@cache
def order_of(rtol: float) -> int:
    """Return the order p that costs least if the step is rtol^(1/p) of the radius of convergence."""
    return min(range(MIN_ORDER, MAX_ORDER + 1), key=lambda p: (PER_STEP + PER_ORDER * p + p * p) * rtol ** (-1.0 / p))


def advance(system: System, options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
    """Advance a planar tree over one leg."""
    own, order = expansion_of(system), order_of(options.rtol)
    tree, is_full = own.tree, own.tree is not system
    state = tree.reduced(y) if is_full else y

    def chunk(outputs: leg.Outputs) -> int:
        return advance_taylor(tree.model, tree.work, own.handle, options, order, run, state, outputs)

    ended = leg.run_chunks(chunk, options, run, state, times)
    if is_full:
        states = np.empty((len(times), len(y)))
        states[: ended.reached] = tree.all_full(ended.states[: ended.reached])
        ended.states, y[:] = states, tree.full(state)
    return ended


INTEGRATORS = (
    leg.Integrator(
        name="taylor",
        kind="adaptive",
        order=MAX_ORDER,
        varies_order=True,
        description="Taylor series of the order that suits the tolerance, adaptive, for small planar trees",
        advance=advance,
        stabilization="none",
        stabilizations=("none",),
        interpolates=True,
        refusals=no_series,
        ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13),
        source="Jorba, Zou, Experimental Mathematics 14 (2005) 99",
    ),
)
