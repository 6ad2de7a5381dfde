"""The findings of the examination of an engine."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

Outcome = Literal["passed", "failed", "exempt"]


@dataclass(frozen=True)
class Finding:
    """The answer to one question about one method on one scene."""

    question: str
    method: str
    scene: str
    outcome: Outcome
    detail: str = ""  # what was seen; a sentence where it failed
    exemption: str = ""  # the weakness that the method declares, where that is why a failure does not count


@dataclass(frozen=True)
class Row:
    """The figures of one method on one scene."""

    method: str
    scene: str
    order: float | None  # observed
    documented: int | None
    error: float | None  # of the best run, over the scene's size, or rad
    loop_s: float | None  # of that run


@dataclass(frozen=True)
class Report:
    """All findings, and the table of figures."""

    engine: str
    version: str
    findings: tuple[Finding, ...]
    rows: tuple[Row, ...]
    uncovered: tuple[str, ...] = ()  # types of parts that it declares and no scene here has

    def of(self, outcome: Outcome) -> tuple[Finding, ...]:
        return tuple(f for f in self.findings if f.outcome == outcome)

    @property
    def conforms(self) -> bool:
        return not self.of("failed")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {**asdict(self), "conforms": self.conforms}


def verdict(question: str, method: str, scene: str, wrong: str, *, seen: str = "", exemption: str = "") -> Finding:
    """Return a finding: passed where nothing is wrong; a failure is exempt by a weakness that the method declares."""
    if not wrong:
        return Finding(question, method, scene, "passed", seen)
    return Finding(question, method, scene, "exempt" if exemption else "failed", wrong, exemption)
