"""The words of a comparison, defined once: verdicts with a code and a meaning, target results, and cells.

Pages, JSON, commands and documents refer to these definitions. Codes are stable: others may cite them.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any, Literal, NamedTuple

from pydantic import computed_field

from cross_checks.records.numbers import duration, short
from cross_checks.records.record import Record
from mbs_ref import scenes
from mbs_ref.display import facts, listing
from mbs_ref.files import package_data

OURS = "mbs_ref"  # the engine that is this project's own solver: compared, and ranked nowhere


class Verdict(StrEnum):
    """What the runs of one method on one scene show."""

    AGREES = "agrees"
    BELOW_TRUTH = "below-truth"
    CONVERGING = "converging"
    NOT_SHOWN = "not-shown"
    WRONG_LIMIT = "wrong-limit"
    LOST = "lost"
    DIVERGED = "diverged"
    FAILED = "failed"
    CRASHED = "crashed"
    TIMEOUT = "timeout"
    OUT_OF_MEMORY = "out-of-memory"
    CANNOT = "cannot"
    ENGINE_MISSING = "engine-missing"


Tone = Literal["good", "fair", "bad", "plain"]


class Meaning(NamedTuple):
    """A verdict's stable code, its tone on a page and its meaning in one sentence."""

    code: str
    tone: Tone
    sentence: str


_STATED = package_data(__name__, "verdicts.toml")
MEANINGS = {verdict: Meaning(**_STATED[verdict]) for verdict in Verdict}
WRONG = frozenset(verdict for verdict, meaning in MEANINGS.items() if meaning.tone == "bad")
REFUSED = frozenset({Verdict.CANNOT, Verdict.ENGINE_MISSING})
SILENT = frozenset({Verdict.WRONG_LIMIT, Verdict.LOST, Verdict.DIVERGED})  # the runs behind them report success

Answer = Literal["reached", "not-tried", "not-reached", "unjudged", "cannot"]
ANSWERS: dict[Answer, tuple[str, Tone]] = {
    "reached": ("reached", "good"),
    "not-tried": ("not tried", "fair"),
    "not-reached": ("not reached", "bad"),
    "unjudged": ("not judged", "plain"),
    "cannot": ("cannot", "plain"),
}  # with word and tone; the first of the answers of its methods is an engine's


@dataclass(frozen=True)
class Omitted:
    """What a run that was omitted would have cost and shown, by the convergence model."""

    setting: float  # step (s) or relative tolerance
    steps: float
    reaches: float  # odds that it reaches the target
    error: float  # over the scene's scales; the median ...
    range: tuple[float, float]  # ... and the central 68 %
    seconds: float | None = None  # of processor time; None where no run shows what a step costs

    def __str__(self) -> str:
        error, low, high = (short(value, 1) for value in (self.error, *self.range))
        error = f"an error of about {error} (68 %: {low} to {high})"
        cost = f"about {short(self.steps, 1)} steps" + (f", {duration(self.seconds)}," if self.seconds else "")
        return f"{cost} and show {error}"


@dataclass(frozen=True)
class TargetResult:
    """What became of one target error."""

    target: float  # over the scene's scales
    answer: Answer
    record: Record | None = None  # of the cheapest run that reached it
    reason: str = ""
    omitted: Omitted | None = None  # the run that would reach it

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: of the record its settings, error and loop time (s)."""
        plain: dict[str, Any] = {"target": self.target, "answer": self.answer, "reason": self.reason}
        plain["omitted"] = None if self.omitted is None else asdict(self.omitted)
        run = self.record
        if run is None or run.error is None:
            return plain
        return plain | {"settings": run.settings, "error": run.error.value, "loop_s": run.times.get("loop_s")}


@dataclass(frozen=True)
class Cell:
    """One method on one scene. Errors are over the scene's scales. Numbers are finite or None."""

    scene: str
    parameters: dict[str, Any]
    engine: str
    method: str  # empty where the engine is not installed
    verdict: Verdict
    reason: str
    exemption: str = ""  # why the method is documented to be wrong on such a scene; empty where it is not
    error: float | None = None  # of the representative run
    compliance: float | None = None  # m or rad
    order: float | None = None  # observed; of fixed-step methods
    documented_order: int | None = None
    uncertainty: float | None = None  # of the truth, over the scene's scales
    truth: str = ""  # its kind: exact, published, converged, or agreed by engines
    setting: str = ""  # of the representative run
    loop_s: float | None = None
    contact: dict[str, float] = field(default_factory=dict)
    targets: tuple[TargetResult, ...] = ()  # their records without histories
    runs: tuple[dict[str, Any], ...] = ()  # setting, status, error of each run, coarse to fine
    odds: float | None = None  # that the verdict is false; None where no probability is involved

    @computed_field
    @property
    def code(self) -> str:
        """The stable code of the verdict."""
        return MEANINGS[self.verdict].code

    @property
    def label(self) -> str:
        """The scene with its parameters, as the command line takes them."""
        return scenes.label(self.scene, self.parameters)

    @property
    def name(self) -> str:
        """The cell's name for `mbs-ref rerun`."""
        return f"{self.label.replace(' ', ',')}/{self.engine}/{self.method}"

    @property
    def tone(self) -> Tone:
        """The tone of the verdict on a page; no worse than fair where a documented weakness exempts the method."""
        tone = MEANINGS[self.verdict].tone
        return "fair" if tone == "bad" and self.exemption else tone

    @property
    def is_wrong(self) -> bool:
        """Whether the verdict classifies the method as wrong, and no documented weakness exempts it here."""
        return self.verdict in WRONG and not self.exemption

    @property
    def is_refused(self) -> bool:
        """Whether the engine ran nothing, for a reason."""
        return self.verdict in REFUSED

    def result(self, target: float) -> TargetResult | None:
        """Return what became of a target error; None where it was not requested."""
        return next((result for result in self.targets if result.target == target), None)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        targets = [result.to_dict() for result in self.targets]
        return asdict(self) | {"verdict": str(self.verdict), "code": self.code, "targets": targets}

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the verdict, its reason, and the runs that it is based on."""
        shown = facts(f"{self.scene}: {self.engine} {self.method}", [
            ("verdict", f"{self.verdict} ({self.code}): {self.reason}"), ("documented weakness", self.exemption),
            ("error of the scene", self.error), ("truth", self.truth), ("order", self.order),
            ("documented order", self.documented_order),
        ])  # fmt: skip
        runs = [(run["setting"], run["status"], run["error"]) for run in self.runs]
        return shown + listing("Runs", ("setting", "status", "error of the scene"), runs)


class Refused(NamedTuple):
    """Methods of an engine that cannot run some scenes for one reason."""

    engine: str
    methods: str
    scenes: str
    reason: str


def refusals(cells: Iterable[Cell]) -> list[Refused]:
    """Return the refused cells, those of one engine and reason together."""
    groups: dict[tuple[str, str], list[Cell]] = {}
    for cell in cells:
        if cell.is_refused:
            groups.setdefault((cell.engine, cell.reason), []).append(cell)

    def joined(names: Iterable[str]) -> str:
        return ", ".join(dict.fromkeys(names))

    return [
        Refused(engine, joined(cell.method or "all" for cell in own), joined(cell.label for cell in own), reason)
        for (engine, reason), own in groups.items()
    ]
