"""A made-up report that looks like a real one: every verdict, failures, refusals, hostile text."""

from __future__ import annotations

import math
from dataclasses import replace

from cross_checks.extremes.fate import Cell as ExtremeCell
from cross_checks.extremes.fate import Fate, Point, made_of
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.capabilities import Ability, Capability
from cross_checks.judge.vocabulary import Cell, TargetResult, Verdict
from cross_checks.records.record import Error, Record
from reports.facts.report_data import ReportData

TIMED = {"loop_median_s": 1.0, "loop_most_s": 2.0, "loop_runs": 3.0}
HOSTILE = "<script>alert('x')</script> & <b>bold</b> | pipe"
SCENES = [("pendulum", {}), ("pendulum_chain", {"links": 3}), ("pendulum_chain", {"links": 10}),
          ("n_four_bar", {"loops": 1}), ("n_four_bar", {"loops": 2}), ("slider_crank", {})]  # fmt: skip
LADDERS = {"fixed": (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4), "adaptive": (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)}
# engine, method, kind, order, seconds a step
METHODS = [
    ("mbs_ref", "dop853", "adaptive", 8, 2e-7), ("mbs_ref", "rk4", "fixed", 4, 1e-7),
    ("mbs_ref", "euler", "fixed", 1, 5e-8),
    ("mbs_ref", "generalized_alpha", "fixed", 2, 4e-7), ("mbs_ref", "radau", "adaptive", 5, 1e-6),
    ("mbs_ref", "lsodar", "adaptive", 6, 4e-6), ("mbs_ref", "dassl", "adaptive", 5, 9e-6),
    ("mbs_ref", "dassl_index3", "adaptive", 5, 9e-6), ("exudyn", "generalized_alpha", "fixed", 2, 2e-5),
    ("exudyn", "trapezoidal", "fixed", 2, 2e-5), ("exudyn", "tree_rk44", "fixed", 4, 2e-6),
    ("pinocchio", "rk4", "fixed", 4, 6e-6), ("pinocchio", "rk4_no_gains", "fixed", 4, 6e-6),
    ("pinocchio", "dop853", "adaptive", 8, 9e-6), ("mujoco", "rk4", "fixed", 4, 1e-6),
    ("mujoco", "rk4_tight", "fixed", 4, 1e-6), ("mujoco", "implicitfast", "fixed", 1, 5e-7),
]  # fmt: skip


def _verdict(scene: str, engine: str, method: str) -> tuple[str, str]:
    loop = scene in ("n_four_bar", "slider_crank")
    if method == "tree_rk44" and loop:
        return "cannot", "tree_rk44 cannot model a scene that is closed-loop"
    if engine == "mujoco" and loop and method != "rk4_tight":
        return "wrong-limit", "the soft loop closure of the default solref settles away from the truth"
    if method == "dassl_index3":
        return "failed", f"IDA could not meet the error test (flag -4) at t = 0.31 s {HOSTILE}"
    if method == "rk4_no_gains" and loop:
        return "diverged", "left the constraint manifold at the singular pose, 0.3 m"
    if method in ("euler", "implicitfast"):
        return "converging", "order 1: 3.1e-3 m at the smallest step tried"
    return "agrees", ""


def _error(verdict: str, kind: str, order: int, knob: float) -> float:
    if verdict == "wrong-limit":
        return 0.31 + 30.0 * knob**2
    if verdict == "diverged":
        return 0.9
    return max(20.0 * knob**order if kind == "fixed" else 3e3 * knob**0.97, 2e-14)


def _history(error: float, compliance: float) -> dict[str, list[float]]:
    t = [0.1 * k for k in range(101)]
    swing = [abs(math.sin(3.0 * s)) + 0.1 for s in t]
    return {
        "t": t,
        "compliance_position": [0.0, *(compliance * s for s in swing[1:])],
        "energy_drift": [0.0, *(30 * error * s * x for s, x in zip(swing[1:], t[1:], strict=True))],
        "error": [0.0, *(error * s * x / 10.0 for s, x in zip(swing[1:], t[1:], strict=True))],
    }


def _record(scene: str, parameters: dict, method: tuple, knob: float, verdict: str, reason: str) -> Record:
    engine, name, kind, order, cost = method
    error = _error(verdict, kind, order, knob)
    steps = int(10.0 / knob) if kind == "fixed" else int(300 * (knob / 1e-4) ** (-1.0 / order))
    ok = verdict != "failed"
    compliance = max(1e-3 * error, 1e-16)
    links = parameters.get("links", 4)
    return Record(
        scene=scene, parameters=parameters, engine=engine, method=name,
        settings={"step": knob, "rtol": None, "t_end": 10.0} if kind == "fixed" else {"rtol": knob, "atol": knob},
        status="success" if ok else "not-converged", message="" if ok else reason, t_end=10.0 if ok else 0.31,
        steps=steps, rhs_calls=steps * 4, final={},
        measures={"compliance_position": compliance, "compliance_velocity": 10 * compliance,
                  "energy_drift": 30 * error if ok else None},
        error=Error(error, "converged: two methods", 3e-13, error, length=2.0) if ok else None,
        times={"build_s": 2e-3, "first_call_s": 4e-4, "loop_s": steps * cost * links / 4} | TIMED,
        versions={engine: "1.2.3"},
        history=_history(error, compliance) if ok else {},
    )  # fmt: skip


def _cell(scene: str, parameters: dict, method: tuple, own: list[Record], verdict: str, reason: str) -> Cell:
    engine, name, _, order, _ = method
    measured = [r.error.value for r in own if r.error]
    error = min(measured, default=None)
    seen = float(order) if verdict in ("agrees", "converging") else None
    compliance = own[-1].measure("compliance_position") if measured else None
    targets = tuple(_target(target, own, verdict, reason) for target in TARGETS)
    word = Verdict(verdict)
    return Cell(scene, parameters, engine, name, word, reason, "", error, compliance, seen, order, targets=targets)


def _target(target: float, own: list[Record], verdict: str, reason: str) -> TargetResult:
    reaching = [r for r in own if r.error and r.error.value <= target]
    if reaching:
        return TargetResult(target, "reached", replace(reaching[0], history={}))
    if verdict == "cannot":
        return TargetResult(target, "cannot", None, reason)
    if verdict == "converging":
        return TargetResult(target, "not-tried", None, "it would take about 1e+07 steps")
    return TargetResult(target, "not-reached", None, "its best is 0.3; finer settings do not help")


def _extremes() -> tuple[ExtremeCell, ...]:
    """Cells with every fate, among them a silent reset and hostile text."""

    def point(value: float, fate: Fate, status: str = "success", reason: str = "") -> Point:
        fine = fate is not Fate.STOPPED
        odds, error = float(fate is Fate.SURVIVED), 1e-4 if status == "success" else None
        return Point(value, fate, odds, fine, error, status, reason)

    fell = [point(1e2, Fate.SURVIVED), point(1e14, Fate.SILENTLY_WRONG, "reset", f"it went on {HOSTILE}")]
    ours = [point(1e2, Fate.SURVIVED), point(1e6, Fate.DEGRADED), point(1e14, Fate.STOPPED, "refused", HOSTILE)]
    whole = [point(1.0, Fate.SURVIVED), point(1e-8, Fate.SURVIVED)]
    return (
        made_of("stiff-spring-quiet", "stiffness", "mujoco", "rk4", False, fell),
        made_of("stiff-spring-quiet", "stiffness", "mbs_ref", "rk4", False, ours),
        made_of("crash-pulse", "pulses", "mbs_ref", "dop853", False, whole),
        ExtremeCell("crash-pulse", "pulses", "mujoco", "rk4", False, Fate.CANNOT, None, (), HOSTILE),
    )


def report_data() -> ReportData:
    """Return the made-up report."""
    records, cells = [], []
    for scene, parameters in SCENES:
        for method in METHODS:
            verdict, reason = _verdict(scene, method[0], method[1])
            knobs = () if verdict == "cannot" else LADDERS[method[2]]
            own = [_record(scene, parameters, method, knob, verdict, reason) for knob in knobs]
            records += own
            cells.append(_cell(scene, parameters, method, own, verdict, reason))
    loops = {"mujoco": Ability("never", "loop closures are always soft"),
             "exudyn": Ability("some", "redundant coordinates only")}  # fmt: skip
    capabilities = [
        Capability(
            engine, True, parts={"revolute": True, "user_force": engine == "mbs_ref"},
            traits={"closed-loop": loops.get(engine, Ability("can"))},
        )
        for engine in ("mbs_ref", "exudyn", "pinocchio", "mujoco")
    ]  # fmt: skip
    capabilities.append(Capability("drake", False, f"engine 'drake' needs the package 'pydrake' {HOSTILE}"))
    environment = {"made": "2026-01-02 03:04 UTC", "python": "3.12.1", "processor": HOSTILE, "exudyn": "1.2.3"}
    return ReportData(tuple(cells), tuple(records), tuple(capabilities), environment, extremes=_extremes())
