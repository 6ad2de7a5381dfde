"""One cell of the matrix of extremes: an engine's method along one axis, as a line of JSON."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

from cross_checks.extremes.fate import Fate, Point
from cross_checks.records import lines as record_file


@dataclass(frozen=True)
class Cell:
    """What became of one method of one engine along one axis."""

    extreme: str
    family: str
    engine: str
    method: str
    full: bool  # the whole axis searched finely, or a quick look at its listed values
    fate: Fate  # the worst that happened
    last: float | None  # most extreme value up to which all went right
    points: tuple[Point, ...]
    reason: str = ""  # why it cannot, or the first of the worst failures

    @property
    def key(self) -> tuple[str, str, str, bool]:
        return self.extreme, self.engine, self.method, self.full

    @property
    def first_failure(self) -> str:
        """What comes beyond `last`; empty where all went right."""
        return next((point.reason for point in self.points if not point.handled), "")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)


def made_of(extreme: str, family: str, engine: str, method: str, full: bool, points: Iterable[Point]) -> Cell:
    """Return the cell of the points, mild first."""
    every = tuple(points)
    handled = tuple(takewhile(lambda point: point.handled, every))
    failures = [point for point in every if not point.handled]
    reason = next((point.reason for point in failures if point.fate is _worst(failures)), "")
    last = handled[-1].value if handled else None
    return Cell(extreme, family, engine, method, full, _worst(every), last, every, reason)


def _worst(points: Sequence[Point]) -> Fate:
    return next(fate for fate in Fate if any(point.fate is fate for point in points))


def from_dict(data: Any) -> Cell:
    """Return the cell that to_dict() gave; TypeError or ValueError names what is wrong."""
    if not isinstance(data, dict):
        raise TypeError(f"a cell is an object, and this is {type(data).__name__}")
    points = tuple(Point(**(point | {"fate": Fate(point["fate"])})) for point in data.get("points", ()))
    return Cell(**(data | {"fate": Fate(data.get("fate")), "points": points}))


def append(path: Path, cell: Cell) -> None:
    """Add a cell to a file in one write."""
    record_file.append_data(path, [cell.to_dict()])


def read(path: Path) -> tuple[list[Cell], list[str]]:
    """Return the cells of a file, the last of each key, and a sentence for every line that is none."""
    cells, problems = record_file.read_data(path, from_dict)
    return list({cell.key: cell for cell in cells}.values()), problems
