"""Certificates of truths: the uncertainty of each, how it was computed, and its digits, stored on disk."""

import json
import math
import re
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mbs_ref import Scene, scenes
from mbs_ref.files import write_atomic
from mbs_ref.observables.distance import Partial, unmasked_distances

FOLDER = Path(__file__).parent / "data" / "certificates"


@dataclass(frozen=True)
class Certificate:
    """What is known of one truth. Lengths in m, times in s."""

    scene: str
    parameters: dict[str, Any]
    t_end: float
    samples: int
    kind: str  # exact | published | converged | ephemeris
    how: str
    uncertainty: float  # of every world point at every time
    difference: float | None  # between two unlike ways; None where it was computed in one
    end: dict[str, list[float | None]]  # body -> centre of mass at t_end; None where the truth does not cover it
    confirmed_by: str  # a run of the reference solver, which takes no part in the computation of the truth
    confirmed_to: float | None  # its largest distance from the truth
    made: str  # UTC date
    versions: dict[str, str]

    @property
    def decimals(self) -> int:
        """Decimals of `end` that hold."""
        return max(0, math.floor(-math.log10(2.0 * self.uncertainty)))


def departure(stored: Certificate, fresh: Certificate) -> float:
    """Return how far (m) the ends of two certificates of one truth are apart; ValueError where they are of two."""
    if (stored.scene, stored.parameters, stored.t_end) != (fresh.scene, fresh.parameters, fresh.t_end):
        raise ValueError(f"{file_name(stored)} and {file_name(fresh)} certify different truths")
    return float(unmasked_distances(_end_of(stored), _end_of(fresh), None)[..., 0].max())


def holds(stored: Certificate, fresh: Certificate) -> bool:
    """Return whether a newly computed truth is the stored one within both uncertainties."""
    return departure(stored, fresh) <= stored.uncertainty + fresh.uncertainty


def _end_of(certificate: Certificate) -> Partial:
    return Partial(np.array([[[0.0 if x is None else x for x in place] for place in certificate.end.values()]]))


def file_name(certificate: Certificate | Scene) -> str:
    """Return the name of the file that holds a truth's certificate: the scene and what is not its default."""
    name = certificate.name if isinstance(certificate, Scene) else certificate.scene
    defaults = scenes.describe(name).parameters
    chosen = [f"{key}={value}" for key, value in certificate.parameters.items() if defaults.get(key) != value]
    return re.sub(r"[^\w=.+-]+", "_", " ".join([name, *chosen])) + ".json"


def write(certificate: Certificate, folder: Path = FOLDER) -> Path:
    """Store a certificate; return its file."""
    target = folder / file_name(certificate)
    folder.mkdir(parents=True, exist_ok=True)
    write_atomic(target, (json.dumps(asdict(certificate), indent=1, allow_nan=False) + "\n").encode())
    return target


def stored(scene: Scene, folder: Path = FOLDER) -> Certificate | None:
    """Return the stored certificate of a scene with its parameters, or None."""
    file = folder / file_name(scene)
    certificate = read(file) if file.is_file() else None
    return certificate if certificate is not None and certificate.parameters == scene.parameters else None


def read(file: Path) -> Certificate:
    """Return the certificate in a file; ValueError names the file where it holds none.

    Parameters that the scene has gained since have their defaults.
    """
    try:
        certificate = Certificate(**json.loads(file.read_text()))
    except (ValueError, TypeError) as error:
        raise ValueError(f"{file} holds no certificate: {error}") from error
    if certificate.scene not in scenes.names():
        return certificate
    full = scenes.describe(certificate.scene).parameters | certificate.parameters
    return replace(certificate, parameters=scenes.applicable(certificate.scene, full))


def every(folder: Path = FOLDER) -> list[Certificate]:
    """Return every stored certificate."""
    return [read(file) for file in sorted(folder.glob("*.json"))]
