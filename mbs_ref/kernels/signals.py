"""Evaluate compiled signals: on a segment a polynomial plus one sinusoid (see mbs_ref.scene.signals)."""

from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.jit import bare


class SignalArrays(NamedTuple):
    """All signals of a scene; signal k owns segments first[k] to first[k + 1]."""

    first: Annotated[Ints, "n_signals + 1"]
    start: Annotated[Floats, "n_segments"]  # s
    coefficients: Annotated[Floats, "n_segments", "degree + 1"]
    amplitude: Annotated[Floats, "n_segments"]
    omega: Annotated[Floats, "n_segments"]  # rad/s
    phase: Annotated[Floats, "n_segments"]  # rad


@bare
def evaluate(signals, k, t, t_mode):
    """Return value, first and second derivative of signal k at t.

    The segment is the one that contains t_mode, a time inside the current step: a step that ends on a
    breakpoint sees the limit from its own side.
    """
    segment = signals.first[k]
    last = signals.first[k + 1] - 1
    while segment < last and signals.start[segment + 1] <= t_mode:
        segment += 1
    tau = t - signals.start[segment]
    value = rate = curvature = 0.0
    for power in range(signals.coefficients.shape[1] - 1, -1, -1):
        curvature = curvature * tau + 2.0 * rate
        rate = rate * tau + value
        value = value * tau + signals.coefficients[segment, power]
    amplitude = signals.amplitude[segment]
    if amplitude != 0.0:
        omega = signals.omega[segment]
        sine = amplitude * np.sin(omega * tau + signals.phase[segment])
        cosine = amplitude * np.cos(omega * tau + signals.phase[segment])
        value += sine
        rate += omega * cosine
        curvature -= omega * omega * sine
    return value, rate, curvature
