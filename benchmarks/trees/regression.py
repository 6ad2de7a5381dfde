"""Is one source tree slower than another at equal error? Both run in the same job, interleaved."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple, Self

from benchmarks.trees import worker as tree_worker
from cross_checks.isolation.parent import ONE_THREAD
from cross_checks.isolation.workers import Report
from cross_checks.prices.timing import Comparison, Pace, Sample, compare, interleaved
from mbs_ref.files import package_data


class Tree:
    """The packages in a folder, alive in a child process. RuntimeError where it does not answer."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        if not (self.folder / "mbs_ref" / "__init__.py").is_file():
            raise ValueError(f"{folder} is no source tree: it has no mbs_ref package")
        self._child = subprocess.Popen(
            [sys.executable, "-P", tree_worker.__file__], cwd=self.folder, text=True,
            env=os.environ | ONE_THREAD | {"PYTHONPATH": str(self.folder)},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        loaded = Path(self._answer()["tree"]).resolve()
        if loaded != self.folder:
            raise RuntimeError(f"the packages of {loaded} were loaded instead of those of {self.folder}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._child.kill()
        self._child.communicate()

    def climb(self, **case: Any) -> list[dict[str, Any]]:
        """Return settings, status, error (of the scene) and loop time (s) of a method's ladder."""
        return self._ask("climb", case)

    def time(self, **case: Any) -> Sample:
        """Time one run."""
        return Sample(**self._ask("time", case))

    def rate(self, **case: Any) -> float:
        """Return the processor time (ns a body) of a right-hand side."""
        return self._ask("rate", case)["ns_per_body"]

    def _ask(self, what: str, case: dict[str, Any]) -> Any:
        assert self._child.stdin is not None
        self._child.stdin.write(json.dumps({"do": what} | case) + "\n")
        self._child.stdin.flush()
        return self._answer()

    def _answer(self) -> Any:
        assert self._child.stdout is not None
        line = self._child.stdout.readline()
        if not line:
            raise RuntimeError(f"the tree {self.folder} does not run: exit code {self._child.wait()}")
        return json.loads(line)


NOT_MEASURED = "not measured"
MOST_PAIRS = 3  # of processes, to confirm that one tree is faster


@dataclass(frozen=True)
class Case:
    """What is timed: the cheapest rung of a method's ladder that reaches `error`."""

    scene: str
    method: str
    parameters: dict[str, Any] = field(default_factory=dict)
    engine: str = "mbs_ref"
    error: float = 1e-6  # of the scene

    @property
    def name(self) -> str:
        chosen = "".join(f" {key}={value}" for key, value in self.parameters.items())
        return f"{self.scene}{chosen} {self.engine} {self.method}"

    @property
    def what(self) -> dict[str, Any]:
        """Scene, parameters and engine, as a Tree receives them."""
        return {"scene": self.scene, "parameters": self.parameters, "engine": self.engine}


STATED = package_data(__name__, "cases.toml")
CASES = tuple(Case(**case) for case in STATED["cases"])


@dataclass(frozen=True)
class Finding:
    """The verdict on a case."""

    case: str
    verdict: str  # faster | same | slower | inconclusive | not measured
    sentence: str
    error: float
    timing: Comparison | None = None

    @property
    def changed(self) -> bool:
        """Whether it says that one tree is faster."""
        return self.verdict in (Pace.FASTER, Pace.SLOWER)


def regressions(
    baseline: Path, current: Path, cases: Sequence[Case] = CASES, progress: Report | None = None, seed: int = 0
) -> Iterator[Finding]:
    """Yield a finding for each case; ValueError where a folder is no source tree. `seed` orders the runs."""
    with Tree(baseline) as before, Tree(current) as after:
        for done, case in enumerate(cases):
            if progress is not None:
                progress(done, len(cases), case.name)
            finding = examine(before, after, case, seed)
            yield confirmed(finding, lambda case=case: _afresh(baseline, current, case)) if finding.changed else finding


def confirmed(first: Finding, again: Callable[[], Finding]) -> Finding:
    """Return what two of up to MOST_PAIRS pairs of processes say, or inconclusive.

    Where a process happens to lie in memory can make all its runs 10 % faster or slower, which no number of runs within
    one pair reveals (T. Mytkowicz and others, Producing wrong data without doing anything obviously wrong,
    ASPLOS 2009).
    """
    findings = [first]
    while len(findings) < MOST_PAIRS:
        findings.append(again())
        if any(findings[-1].verdict == earlier.verdict for earlier in findings[:-1]):
            return findings[-1]
    sentence = "; ".join(f"{finding.verdict}: {finding.sentence}" for finding in findings)
    return replace(first, verdict=str(Pace.INCONCLUSIVE), sentence=f"pairs of processes disagree: {sentence}")


def _afresh(baseline: Path, current: Path, case: Case) -> Finding:
    with Tree(baseline) as before, Tree(current) as after:
        return examine(before, after, case)


def examine(before: Tree, after: Tree, case: Case, seed: int = 0) -> Finding:
    """Choose each tree's cheapest setting that reaches the error, and time the two against each other."""
    what = case.what
    chosen = [cheapest(tree.climb(**what, method=case.method), case.error) for tree in (before, after)]
    for settings, name in zip(chosen, ("baseline", "current tree"), strict=True):
        if settings is None:
            text = f"no setting of the {name} reaches {case.error:g} of the scene"
            return Finding(case.name, NOT_MEASURED, text, case.error)
    first, second = chosen
    timing = compare(lambda: before.time(**what, settings=first), lambda: after.time(**what, settings=second), seed)
    return Finding(case.name, timing.pace, _sentence(timing, case), case.error, timing)


def cheapest(rungs: list[dict[str, Any]], error: float) -> dict[str, Any] | None:
    """Return the coarsest settings that reach the error: coarse is cheap, and counting is not disturbed by noise."""
    reached = (r for r in rungs if r["status"] == "success" and r["error"] is not None and r["error"] <= error)
    first = next(reached, None)
    return None if first is None else first["settings"]


def _sentence(timing: Comparison, case: Case) -> str:
    change = f"{timing.ratio:.3f} times the baseline's loop time [{timing.low:.3f}, {timing.high:.3f}]"
    busy = f"; {timing.disturbed:.0%} of the runs shared the machine" if timing.disturbed > 0.1 else ""
    return f"{change} to {case.error:g} of the scene, {timing.blocks} blocks{busy}"


class Rate(NamedTuple):
    """A right-hand side in two trees, ns a body (least of all rounds), and new / old (median of paired ratios)."""

    scene: str
    parameters: dict[str, Any]
    old_ns_per_body: float
    new_ns_per_body: float
    ratio: float


ROUNDS = 15  # pairs, each in an order of its own
SECONDS = 0.02  # of processor time a measurement


def rate_of(old: Tree, new: Tree, scene: str, parameters: dict[str, Any]) -> Rate:
    """Measure the right-hand side of one scene in both trees, in turns."""
    runs = [partial(tree.rate, scene=scene, parameters=parameters, seconds=SECONDS) for tree in (old, new)]
    times = interleaved(runs, ROUNDS)
    ratios = [after / before for before, after in zip(*times, strict=True)]
    return Rate(scene, parameters, min(times[0]), min(times[1]), median(ratios))


def overall(findings: Sequence[Finding]) -> str:
    """Return slower where any case is; not measured or inconclusive where any is that; else faster or same."""
    verdicts = {finding.verdict for finding in findings}
    order = (str(Pace.SLOWER), NOT_MEASURED, str(Pace.INCONCLUSIVE), str(Pace.FASTER), str(Pace.SAME))
    return next((word for word in order if word in verdicts), NOT_MEASURED)
