"""What the report says of each scene's truth: its certificate made now, and the one kept."""

from __future__ import annotations

from dataclasses import dataclass

from cross_checks.certificates import certificate
from cross_checks.certificates.certificate import Certificate
from cross_checks.truth import NoTruth
from mbs_ref.scene import Scene


@dataclass(frozen=True)
class TruthFacts:
    """One scene's truth, or the reason for having none."""

    scene: str  # label, with parameters
    made: Certificate | NoTruth
    kept: Certificate | None

    @property
    def departs_by(self) -> float | None:
        """How far (m) the truth made now ends from the one kept; None where one is missing."""
        if self.kept is None or isinstance(self.made, NoTruth):
            return None
        return certificate.departure(self.kept, self.made)

    @property
    def holds(self) -> bool | None:
        """Whether the two agree to what they claim to know; None where one is missing."""
        if self.kept is None or isinstance(self.made, NoTruth):
            return None
        return certificate.holds(self.kept, self.made)


def truth_facts(scenes: dict[str, Scene]) -> tuple[TruthFacts, ...]:
    """Return the facts of each labelled scene."""
    return tuple(
        TruthFacts(label, certificate.certify(scene, confirm=False), certificate.stored(scene))
        for label, scene in scenes.items()
    )
