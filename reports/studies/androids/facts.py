"""What is measured of the androids."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cross_checks.judge.vocabulary import Cell
from reports.facts.curves import Curves
from reports.studies.study import Study


@dataclass(frozen=True)
class Run:
    """One android under one method and setting."""

    scene: str
    impact: str
    method: str
    settings: dict[str, Any]
    status: str
    message: str
    steps: int
    rejected: int
    rhs_calls: int
    switches: int | None  # between Adams and BDF; None where none are kept
    events: int
    loop_s: float
    compliance: float | None  # m, largest |C| of the steps; None where no step was made
    curve: Curves | None  # of |C| since the last sample, m
    paper_test: str  # how the papers' test |C| < h at every step ends
    error: float | None  # m, from the truth, largest over bodies and samples; None where the run stopped

    @property
    def ok(self) -> bool:
        return self.status == "success"


@dataclass(frozen=True)
class Stable:
    """What the linearised motion allows, and what becomes of a longer step."""

    scene: str
    real: tuple[float, ...]  # 1/s, of the eigenvalues
    imaginary: tuple[float, ...]
    fastest_decay: float  # 1/s
    rules: dict[str, float]  # the papers' rules -> s, where they say something
    limits: dict[str, float | None]  # explicit method -> s; None where nothing is fast
    beyond: float  # s, a step that RK4 cannot bear
    refusal: str  # the sentence that meets it
    forced: str  # how it ends if it is run all the same


@dataclass(frozen=True)
class Convergence:
    """Two unlike integrators on one android and impact."""

    scene: str
    impact: str
    gaps: Curves  # head, hip: m between the two methods, from the second sample on
    compliance: dict[str, float]  # method -> m, largest |C|
    error: float | None  # m, of DOP853 from the truth
    uncertainty: float | None  # m, of the truth


@dataclass(frozen=True)
class Peer:
    """A method of another engine on one android and impact."""

    cell: Cell
    reaction_error: float | None  # N, largest difference of a joint force from ours; None where it gives none


@dataclass(frozen=True)
class AndroidFacts:
    """Everything measured."""

    runs: tuple[Run, ...]
    stable: tuple[Stable, ...]
    convergence: tuple[Convergence, ...]
    peers: tuple[Peer, ...]  # of other engines


STUDY = Study("androids.html", "The crash androids", AndroidFacts, place=1)
