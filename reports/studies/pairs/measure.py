"""Every pair: both at the same target errors, relative to the scene, and timed in interleaved runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from cross_checks import engines
from cross_checks.engine import Engine, Method
from cross_checks.judge import ladder
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.judge.vocabulary import TargetResult
from cross_checks.records.store import Store, default_path
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from reports.facts.turns import least_times
from reports.reproduce import scene_label
from reports.studies.pairs.facts import Pair, PairsFacts, Row
from reports.studies.pairs.sky_places import sky_places

OURS = "mbs_ref"
Entrants = tuple[tuple[str, tuple[str, ...]], ...]  # engine and its methods; none named stands for all that run it


@dataclass(frozen=True)
class Asked:
    """A pair: its scenes, who enters, and the targets over the scenes' scales."""

    title: str
    note: str
    scenes: tuple[tuple[str, dict[str, Any]], ...]
    entrants: Entrants
    targets: tuple[float, ...] = (1e-3, 1e-6)


SHARED = "Forces of contacts and belts are ours, called from Python: dynamics is what is compared."
CHAINS = Asked(
    "Chains and loops: Exudyn, Pinocchio", "Pinocchio is driven from Python, by its own stepping there.",
    (("pendulum_chain", {"links": 10}), ("n_four_bar", {"loops": 2}), ("slider_crank", {})),
    ((OURS, ("dop853", "rk4")), ("exudyn", ("tree_dopri5", "generalized_alpha")), ("pinocchio", ("dop853",))),
)  # fmt: skip
SMALL = Asked(
    "The simplified android: Exudyn, Pinocchio", SHARED,
    tuple(("android_simplified", {"impact": impact}) for impact in ("front", "rear")),
    ((OURS, ("dop853", "rk4")), ("exudyn", ("tree_dopri5",)), ("pinocchio", ("dop853",))),
)  # fmt: skip
LARGE = Asked(
    "The vertebral android: Exudyn, Pinocchio", f"{SHARED} Exudyn's fixed step from the rear would take minutes a run.",
    (("android_vertebral", {}),),
    ((OURS, ("dop853", "rk4")), ("exudyn", ("tree_rk44",)), ("pinocchio", ("dop853",))), (1e-3,),
)  # fmt: skip
LARGE_REAR = Asked(
    "The vertebral android from the rear: Pinocchio", SHARED, (("android_vertebral", {"impact": "rear"}),),
    ((OURS, ("dop853", "rk4")), ("pinocchio", ("dop853",))), (1e-3,),
)  # fmt: skip
CONTACT = Asked(
    "Contact: MuJoCo", "MuJoCo by its own contact, its reference set to the law; what it cannot model it says.",
    (
        ("bouncing_ball", {"law": "spring_damper_force"}), ("rolling_disc", {}), ("rolling_sphere", {}),
        ("sliding_block", {}), ("incline", {}), ("block_stack", {}), ("newtons_cradle", {}),
    ),
    ((OURS, ("dop853", "rk4")), ("mujoco", ("rk4", "implicitfast"))), (1e-3, 1e-6),
)  # fmt: skip
SATELLITES = Asked(
    "Satellites: REBOUND, heyoka", "J2; REBOUND takes its force from our code.",
    tuple(("satellite", {"orbit": orbit}) for orbit in ("leo", "gps", "molniya")),
    ((OURS, ("gauss", "dop853")), ("rebound", ("ias15", "bs")), ("heyoka", ("taylor",))), (1e-6, 1e-9),
)  # fmt: skip
PLANETS = Asked(
    "Planets: REBOUND, heyoka", "Newton's gravity over 360 days; targets count in the tightest orbit of two.",
    (("solar_system", {"model": "lumped"}),),
    ((OURS, ("gauss", "dop853", "rk4")), ("rebound", ("ias15", "whfast", "bs")), ("heyoka", ("taylor",))),
    (1e-6, 1e-9, 1e-11),
)  # fmt: skip
PAIRS = (CHAINS, SMALL, LARGE, LARGE_REAR, CONTACT, SATELLITES, PLANETS)


def measure() -> PairsFacts:
    """Search and time everything; the store keeps the searched runs."""
    with Store(default_path()) as store:
        return PairsFacts(tuple(pair(Runs(store), asked) for asked in PAIRS), sky_places())


def pair(runs: Runs, asked: Asked) -> Pair:
    """Answer every scene of a pair."""
    made = (scenes.make(name, **parameters) for name, parameters in asked.scenes)
    return Pair(asked.title, asked.note, tuple(row for scene in made for row in compared(runs, scene, asked)))


def compared(runs: Runs, scene: Scene, asked: Asked) -> list[Row]:
    """Return the rows of one scene, timed together target by target."""
    truth = runs.truth(scene)
    able, refused = _entrants(scene, asked)
    winners = [
        (name, method, reached)
        for name, method in able
        for reached in search(runs, scene, name, method, truth, asked.targets)[1]
    ]
    timed = [row for target in asked.targets for row in _timed(scene, [w for w in winners if w[2].target == target])]
    return timed + refused


def parts() -> list[tuple[int, int, int]]:
    """Return every search as a pair, a scene of it and an entrant, counted: they may be made in any order."""
    return [
        (k, number, entrant)
        for k, asked in enumerate(PAIRS)
        for number, (name, parameters) in enumerate(asked.scenes)
        for entrant in range(len(_entrants(scenes.make(name, **parameters), asked)[0]))
    ]


def make(part: tuple[int, int, int]) -> None:
    """Search once: the store keeps the runs, among which `measure` finds its winners."""
    asked = PAIRS[part[0]]
    name, parameters = asked.scenes[part[1]]
    scene = scenes.make(name, **parameters)
    engine, method = _entrants(scene, asked)[0][part[2]]
    with Store(default_path()) as store:
        runs = Runs(store)
        search(runs, scene, engine, method, runs.truth(scene), asked.targets)


def _entrants(scene: Scene, asked: Asked) -> tuple[list[tuple[str, Method]], list[Row]]:
    """Return who can run a scene, and a row for everyone who cannot."""
    able, refused = [], []
    for name, methods in asked.entrants:
        engine = _engine(name)
        if isinstance(engine, str):
            refused.append(Row(_label(scene), name, "", None, "engine-missing", engine))
            continue
        refusals = [refusal.reason for refusal in engine.refusals(scene)]
        if refusals:
            refused.append(Row(_label(scene), name, "", None, "cannot", refusals[0]))
            continue
        for method in (m for m in engine.methods() if m.name in methods):
            reasons = engine.method_refusals(scene, method)
            if reasons:
                refused.append(Row(_label(scene), name, method.name, None, "cannot", reasons[0].reason))
            else:
                able.append((name, method))
    return able, refused


def _engine(name: str) -> Engine | str:
    try:
        return engines.get(name)
    except engines.EngineMissing as missing:
        return str(missing)


def _label(scene: Scene) -> str:
    return scene_label(scene.name, scene.parameters)


def _timed(scene: Scene, entrants: Sequence[tuple[str, Method, TargetResult]]) -> list[Row]:
    """Time everyone who reached a target in randomly interleaved runs."""
    rows = [_row(scene, *entrant) for entrant in entrants]
    ran = [k for k, row in enumerate(rows) if row.answer == "reached"]
    times = ladder.grid(scene)

    def again(k: int) -> float:
        name, _, reached = entrants[k]
        assert reached.record is not None
        return engines.get(name).run(scene, Settings(**reached.record.settings), times).timing.loop_s

    first = [_loop_time(entrants[k][2]) for k in ran]
    best = dict(zip(ran, least_times([partial(again, k) for k in ran], first), strict=True))
    ours = min((best[k] for k in ran if rows[k].engine == OURS), default=None)
    return [
        replace(row, loop_s=best[k], ratio=None if ours is None else best[k] / ours) if k in best else row
        for k, row in enumerate(rows)
    ]


def _loop_time(reached: TargetResult) -> float:
    """Return the loop time (s) of the run that was searched for."""
    return math.inf if reached.record is None else reached.record.times.get("loop_s", math.inf)


def _row(scene: Scene, engine: str, method: Method, reached: TargetResult) -> Row:
    record = reached.record
    if record is None or record.error is None:
        return Row(_label(scene), engine, method.name, reached.target, reached.answer, reached.reason)
    constrained = bool(scene.joints)
    return Row(
        _label(scene), engine, method.name, reached.target, reached.answer, reached.reason,
        ladder.label(Settings(**record.settings)), record.error.value,
        record.measure("compliance_position") if constrained else None, record.measure("energy_drift"),
    )  # fmt: skip
