"""The cheapest measured setting that reaches an accuracy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from cross_checks.record import Record


@dataclass(frozen=True)
class Choice:
    """The recommendation, or the sentence why there is none."""

    best: Record | None
    runner_up: Record | None  # the cheapest of another engine or method
    margin: float | None  # how many times cheaper the best is than the runner-up
    sentence: str


def pick(
    records: Iterable[Record], error: float, compliance: float | None = None, budget: float | None = None
) -> Choice:
    """Return the cheapest measured setting with error (m), compliance (m, rad) and loop time (s) within bounds.

    Only measured runs count, nothing is extrapolated, and the truth's uncertainty is added to the
    error. ValueError where a bound is not positive or the records are of several scenes.
    """
    measured = [r for r in records if _is_measured(r)]
    _check(measured, error=error, compliance=compliance, budget=budget)
    reached = [r for r in measured if _error(r) <= error and _compliance_ok(r, compliance)]
    affordable = sorted((r for r in reached if budget is None or _cost(r) <= budget), key=_cost)
    if not affordable:
        return Choice(None, None, None, _why_none(measured, reached, error, compliance, budget))
    best = affordable[0]
    second = next((r for r in affordable if (r.engine, r.method) != (best.engine, best.method)), None)
    margin = None if second is None else _cost(second) / _cost(best)
    return Choice(best, second, margin, _why(best, second, margin))


def _is_measured(record: Record) -> bool:
    return record.status == "success" and record.error is not None and record.times.get("loop_s", 0.0) > 0.0


def _check(records: Sequence[Record], **bounds: float | None) -> None:
    for name, value in bounds.items():
        if value is not None and not value > 0.0:
            raise ValueError(f"{name} = {value} must be positive")
    found = {(r.scene, tuple(sorted(r.parameters.items()))) for r in records}
    if len(found) > 1:
        raise ValueError(f"the records are of {len(found)} scenes; choose among those of one")


def _error(record: Record) -> float:
    return float("inf") if record.error is None else record.error.value + record.error.uncertainty


def _cost(record: Record) -> float:
    return record.times["loop_s"]


def _compliance_ok(record: Record, bound: float | None) -> bool:
    position = record.compliance.get("position")
    return bound is None or (position is not None and position <= bound)


def setting(record: Record) -> str:
    """Return engine, method and step or tolerance as a reader would say them."""
    step, rtol = record.settings.get("step"), record.settings.get("rtol")
    how = f"step={step:.6g}" if step is not None else f"rtol={rtol:.1g}" if rtol is not None else "its defaults"
    return f"{record.engine} {record.method} {how}"


def _why(best: Record, second: Record | None, margin: float | None) -> str:
    text = f"{setting(best)} reaches {_error(best):.1e} m in {1e3 * _cost(best):.3g} ms"
    if second is None or margin is None:
        return f"{text}; no other method reaches it"
    return f"{text}, {margin:.3g} times cheaper than {setting(second)} ({1e3 * _cost(second):.3g} ms)"


def _why_none(
    measured: Sequence[Record],
    reached: Sequence[Record],
    error: float,
    compliance: float | None,
    budget: float | None,
) -> str:
    if not measured:
        return "no run with a known error was measured"
    if reached and budget is not None:
        cheapest = min(reached, key=_cost)
        price = f"{1e3 * _cost(cheapest):.3g} ms"
        return f"none within {1e3 * budget:.3g} ms; the cheapest is {setting(cheapest)} at {price}"
    close = [r for r in measured if _error(r) <= error]
    if close and compliance is not None:
        return f"{len(close)} settings reach {error:.1e} m, but none keeps the constraints within {compliance:.1e}"
    nearest = min(measured, key=_error)
    return f"none reached {error:.1e} m; the nearest is {setting(nearest)} with {_error(nearest):.1e} m"
