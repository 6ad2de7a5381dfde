"""A seeded defect: one expression of a source replaced by a wrong one."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDER = Path(__file__).parent
LISTS = ("by_hand.jsonl", "by_operator.jsonl")


@dataclass(frozen=True)
class Defect:
    """What is written where, and what it breaks."""

    file: str  # from the root of the tree
    old: str  # occurs once in the file
    new: str
    breaks: str
    reason: str = ""  # why no test can notice it, where that is known

    @property
    def name(self) -> str:
        """A name that stays while the defect is the same."""
        return hashlib.sha256(f"{self.file}\n{self.old}\n{self.new}".encode()).hexdigest()[:10]


class StaleError(ValueError):
    """The text that a defect replaces is not there, or there more than once."""


def every(folder: Path = FOLDER) -> list[Defect]:
    """Return all defects kept, those written by hand first."""
    return [defect for name in LISTS for defect in read(folder / name)]


def read(file: Path) -> list[Defect]:
    """Return the defects kept in a file."""
    return [Defect(**json.loads(line)) for line in file.read_text().splitlines() if line]


def write(defects: Iterable[Defect], file: Path) -> None:
    """Keep defects, one a line."""
    lines = (json.dumps({k: v for k, v in asdict(d).items() if v or k != "reason"}) for d in defects)
    file.write_text("\n".join(lines) + "\n")


def place(defect: Defect, root: Path) -> Path:
    """Return the file that the defect is applied to; StaleError where its text is not found exactly once.

    A file that has moved is found by the text, if it occurs once among all sources.
    """
    file = root / defect.file
    if file.is_file() and file.read_text().count(defect.old) == 1:
        return file
    layer = root / Path(defect.file).parts[0]
    holders = [other for other in sorted(layer.rglob("*.py")) if defect.old in other.read_text()]
    if len(holders) == 1 and holders[0].read_text().count(defect.old) == 1:
        return holders[0]
    raise StaleError(f"{defect.file}: {defect.old!r} is found in {len(holders)} files; it must be found once")


def apply(defect: Defect, root: Path) -> Path:
    """Write the defect into the tree at `root`; return the file changed."""
    file = place(defect, root)
    file.write_text(file.read_text().replace(defect.old, defect.new))
    return file


def stale(defects: Iterable[Defect], root: Path = ROOT) -> list[str]:
    """Return a sentence for each defect whose text is not found exactly once."""
    sentences = []
    for defect in defects:
        try:
            place(defect, root)
        except StaleError as error:
            sentences.append(str(error))
    return sentences
