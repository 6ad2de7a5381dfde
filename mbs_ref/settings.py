"""Settings of a run: method, step or tolerances, stabilization, outputs. All engines share them."""

from typing import Literal, Self

from pydantic import Field, model_validator

from mbs_ref.scene.base.part import NonNegative, Part, Positive
from mbs_ref.scene.traits import Coordinates

Stabilization = Literal["none", "baumgarte", "projection"]


class Settings(Part):
    """Method and accuracy of a run. Give a step for fixed-step methods, rtol and atol for adaptive ones."""

    method: str | None = None  # the engine's default unless given; with 'auto' mbs_ref chooses
    step: Positive | None = None  # s
    rtol: Positive | None = None
    atol: Positive | None = None  # m, rad, m/s, rad/s; unless given, rtol times a tenth of the scene's scale of each
    stabilization: Stabilization | None = None  # the engine's default unless given
    coordinates: Coordinates = "cartesian"  # of bodies, with constraint rows; or of a tree's joints, without rows
    baumgarte_gain: Positive = 20.0  # 1/s, critically damped: C'' + 2 g C' + g^2 C = 0
    t_end: Positive | None = None  # s, the scene's duration unless given
    samples: int = Field(default=101, ge=2, le=1_000_000)  # number of output times, evenly spaced from 0 to t_end
    outputs: Literal["landed", "dense"] = "landed"  # steps end at output times, or the method interpolates there
    max_steps: int = Field(default=50_000_000, ge=1)
    stop_on_compliance: bool = False  # the papers' test |C(q, t)| < h ends the run
    # touch-down, lift-off, slip, slack: located as roots, or forces merely clipped; the method's default unless given
    events: Literal["located", "none"] | None = None
    refuse_unstable: bool = True  # refuse an explicit fixed step that is unstable for the linearised motion
    estimate: Literal["on", "off"] = "on"  # of the error, by a second run outside of the timing
    project_initial: bool = False  # repair inconsistent initial conditions and report the correction
    reactions: bool = True  # evaluate joint reactions at the output times, after the timed loop
    initial_tolerance: NonNegative = 1e-9  # m or rad (m/s, rad/s), largest inconsistency accepted at t = 0

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.step is not None and (self.rtol is not None or self.atol is not None):
            raise ValueError("give either step or rtol/atol, not both")
        return self
