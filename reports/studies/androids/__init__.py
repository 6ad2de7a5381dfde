"""The androids under the papers' integrators and others: compliance, work, stable steps, convergence, engines."""

from functools import cache, partial
from importlib.util import find_spec
from itertools import product

import numpy as np

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.judge import ladder
from cross_checks.judge.bounds import longest
from cross_checks.judge.cell import cell_of
from cross_checks.judge.one_run import judged_run
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.metrics.metric import off_truth
from cross_checks.records.numbers import ABSENT, in_words, order_of, setting, short
from cross_checks.records.store import Store, default_path
from cross_checks.truths import truth_for
from mbs_ref import Scene, Settings, Status, Trajectory, scenes
from mbs_ref.files import package_data
from mbs_ref.integrators import integrators
from mbs_ref.observables import constraint_residual
from mbs_ref.observables.distance import distances
from mbs_ref.simulate import simulate
from mbs_ref.simulate.linearised import stiffness_at_start
from reports.facts.curves import Curves, Measured, Row, curves, plain
from reports.studies.crash import IMPACTS, NAMES, PAPER, SIMPLIFIED, with_test

PAPER_CRASH = f"{SIMPLIFIED}, front"
RUNS = package_data(__name__, "runs.toml")
FINE = 1e-9  # rtol at which two unlike methods are compared
MOST_STEPS = 20_000  # of a run; the longest that is meant to end takes 8 000
TESTED = ("rk4", "euler", "lsodar")  # the papers' methods, whose compliance test is run, too
UNLIKE = ("dop853", "radau")  # explicit of order 8, implicit of order 5
WATCHED = {"head": "head", "hip": "bottom"}
PEER_TARGETS = {"adaptive": (1e-3, 1e-6), "fixed": (1e-3,)}  # over the scene's scales; finer takes minutes


def parts() -> list[tuple[str, ...]]:
    """Return the parts: each crash by our methods, each android's stable steps, each crash by a method of another."""
    crashes = list(product(NAMES, IMPACTS))
    searched = [("engines", *crash, name, method.name) for crash in crashes for name, method in entrants(_bare(*crash))]
    return [*(("methods", *crash) for crash in crashes), *(("stable", name) for name in NAMES), *searched]


def measure_part(part: tuple[str, ...], full: bool = False) -> Measured:
    """Measure a part; the vertebral android's truths are stored on disk. `full` makes runs that take long, too."""
    kind, *about = part
    return {"methods": _methods, "stable": _stable, "engines": partial(_peer, longest(full))}[kind](*about)


def _bare(name: str, impact: str) -> Scene:
    return scenes.make(name, impact=impact, **PAPER)


def _methods(name: str, impact: str) -> Measured:
    measured, scene = Measured(tables={"engines": ()}), _bare(name, impact)
    runs = add_numerics(measured, scene)
    add_convergence(measured, scene, {str(s.method): path for s, path in runs if s.method in UNLIKE and s.rtol == FINE})
    return measured


def _stable(name: str) -> Measured:
    add_stable(measured := Measured(), scenes.make(name, **PAPER))
    return measured


def _peer(most: float, name: str, impact: str, engine: str, method: str) -> Measured:
    with Store(default_path()) as store:
        row = peer(Runs(store, longest=most), _bare(name, impact), engine, engines.get(engine).method(method))
    return Measured(tables={"engines": (row,)})


def label(scene: Scene) -> str:
    """Return android and impact."""
    return f"{scene.name}, {scene.parameters['impact']}"


def _add(measured: Measured, table: str, row: Row) -> None:
    measured.tables[table] = (*measured.tables.get(table, ()), row)


# --- methods of integration ------------------------------------------------------------------------------


def add_numerics(measured: Measured, scene: Scene) -> list[tuple[Settings, Trajectory]]:
    """Run the papers' methods without stabilization, and the others as they come; return the runs."""
    stated = (*RUNS["fixed"][scene.name], *RUNS["adaptive"].get(label(scene), RUNS["adaptive"]["others"]))
    packages = {name: method.package for name, method in integrators().items()}
    settings = [Settings(**one) for one in stated if (need := packages[one["method"]]) is None or find_spec(need)]
    _add(measured, "androids", {"android": label(scene)})
    return [(one, add_run(measured, scene, one)) for one in settings]


def add_run(measured: Measured, scene: Scene, settings: Settings) -> Trajectory:
    """Add one setting: the papers' methods under the papers' test, and again without it where it stops them.

    A method that locates no events takes the forces as the state clips them.
    """
    events = {} if integrators()[str(settings.method)].locates_events else {"events": "none"}
    common = {"reactions": False, "estimate": "off", "max_steps": MOST_STEPS}
    settings, tested = settings.model_copy(update=common | events), settings.method in TESTED
    path, test, error = with_test(scene, settings, tested)
    kept = "kept to the end" if test.ok else "not reached"
    method = f"{settings.method}, {setting({'step': settings.step, 'rtol': settings.rtol})}"
    gaps = path.step_compliance if path.step_compliance is not None and len(path.step_compliance) else None
    compliance = None if gaps is None else _finite(float(np.max(gaps[:, 1])))
    _add(measured, "runs", {
        "android": label(scene), "method": method,
        "end": "reached 0.2 s" if path.ok else f"{path.status}: {path.message}", "error": error,
        "compliance": compliance, "steps": int(path.steps), "rejected": int(path.rejected_steps),
        "rhs_calls": int(path.rhs_calls), "switches": path.method_switches, "events": int(path.events),
        "loop_s": float(path.timing.loop_s),
        "test": "not requested" if not tested else test.message if test.status is Status.COMPLIANCE else kept,
    })  # fmt: skip
    if label(scene) == PAPER_CRASH and settings.step:
        measured.figures[f"androids.{settings.method}.compliance"] = compliance
    good = None if gaps is None else gaps[1:][np.isfinite(gaps[1:, 1])]  # |C| as long as it is finite
    if good is not None and len(good):
        lines = curves(good[:, 0], {"|C|": good[:, 1]}, "largest |C| since the last sample, m", log=True)
        measured.curves[f"compliance: {label(scene)}: {method}"] = lines
    return path


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


# --- stable steps -----------------------------------------------------------------------------------------


def add_stable(measured: Measured, scene: Scene) -> None:
    """Linearise the motion at the start, request a step that is too long, and take it all the same."""
    result = stiffness_at_start(scene)
    limits = {name: _finite(float(result.step_limit(m.stability))) for name, m in integrators().items() if m.stability}
    beyond = RUNS["beyond"][scene.name]
    refused = Settings(method="rk4", step=beyond, samples=26, reactions=False)
    forced = simulate(scene, refused.model_copy(
        update={"stabilization": "none", "estimate": "off", "refuse_unstable": False, "max_steps": MOST_STEPS}
    ))  # fmt: skip
    rules = {"1/omega": result.oscillation_rule, "m/c": result.damping_rule}
    known = ", ".join(f"{name} = {short(value)} s" for name, value in rules.items() if np.isfinite(value))
    _add(measured, "stable", {
        "android": scene.name, "decay": result.fastest_decay, "beyond": beyond,
        "limits": ", ".join(f"{name} {short(limit)} s" for name, limit in limits.items()),
        "rules": f" The papers' rules: {known}." if known else "",
        "refusal": simulate(scene, refused).message, "forced": f"{forced.status}: {forced.message}",
    })  # fmt: skip
    modes = {"eigenvalues": plain(np.imag(result.modes))}
    measured.curves[f"eigenvalues: {scene.name}"] = Curves(
        plain(np.real(result.modes)), modes, "imaginary part, 1/s", "real part, 1/s", marks="markers"
    )


# --- convergence ------------------------------------------------------------------------------------------


def add_convergence(measured: Measured, scene: Scene, paths: dict[str, Trajectory]) -> Row:
    """Compare the head's and the hip's path by two unlike integrators (`paths`, by method), and with the truth."""
    times = ladder.grid(scene)
    one, other = (paths[method] for method in UNLIKE)
    apart = distances(scene, one, other)[..., 0]
    gaps = {label: apart[:, scene.body_index(body)] for label, body in WATCHED.items()}
    truth = truth_for(scene, times)
    compliance = {m: float(np.abs(constraint_residual(scene, path)).max()) for m, path in paths.items()}
    off = off_truth(scene, one)
    row: Row = {
        "android": label(scene), **{name: float(gap[1:].max()) for name, gap in gaps.items()}, **compliance,
        "error": None if off is None else off[0], "uncertainty": None if truth is None else truth.uncertainty,
    }  # fmt: skip
    _add(measured, "convergence", row)
    lines = {part: gap[1:] for part, gap in gaps.items()}
    measured.curves[f"gaps: {label(scene)}"] = curves(times[1:], lines, "distance, m", log=True)
    return row


# --- engines ----------------------------------------------------------------------------------------------


def entrants(scene: Scene) -> list[tuple[str, Method]]:
    """Return the methods of every other engine that can run the scene: all in the first crash, few in the others."""
    others = (engine for engine in engines.installed() if engine.name != "mbs_ref")
    able, few = [(one.name, method) for one in others for method in one.able(scene)], RUNS["engines"].get(label(scene))
    return [(name, method) for name, method in able if few is None or f"{name} {method.name}" in few]


@cache
def _ours(name: str, impact: str) -> Trajectory:
    scene = _bare(name, impact)
    return simulate(scene, Settings(rtol=FINE, estimate="off"), ladder.grid(scene))


def peer(runs: Runs, scene: Scene, engine: str, method: Method) -> Row:
    """Judge one method; its joint forces are compared with ours at the setting that speaks for it."""
    truth = runs.truth(scene)
    tried, answers = search(runs, scene, engine, method, truth, PEER_TARGETS[method.kind])
    cell = cell_of(tried, answers)
    spoken = next((r for r in tried.records.values() if ladder.label(Settings(**r.settings)) == cell.setting), None)
    forces = None
    if spoken is not None:
        ours = _ours(scene.name, str(scene.parameters["impact"]))
        again, _ = judged_run(
            scene, engine, Settings(**spoken.settings), ladder.grid(scene), truth=truth, reference=ours
        )
        forces = again.measure("reaction_error")
    return {
        "android": label(scene), "method": f"{engine} {method.name}", "verdict": f"{cell.verdict} {cell.code}",
        "error": cell.error, "order": order_of(cell.order, cell.documented_order) or ABSENT,
        "setting": in_words(cell.setting) or ABSENT, "loop_s": cell.loop_s, "forces": forces, "reason": cell.reason,
    }  # fmt: skip
