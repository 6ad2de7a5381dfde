"""One line an engine that an engineer can act on: what to trust it for, at which setting, and where it goes wrong."""

from collections import Counter
from dataclasses import dataclass

from cross_checks.judge.bounds import MOST_STEPS, TARGETS
from cross_checks.judge.vocabulary import OURS, SILENT
from cross_checks.records.numbers import count, short
from cross_checks.records.record import Record
from reports.facts.report_data import MIDDLE, ReportData, Section, entries, reaching, standings
from reports.page.findings import findings


@dataclass(frozen=True)
class Advice:
    """What the first screen says of an engine."""

    engine: str
    use: str  # the method and setting
    reach: str  # on how many scenes it reaches what
    limit: str  # what it cannot model, and what it does not reach
    silent: tuple[str, ...]  # what it gets wrong with success reported, a method each, the worst first
    pace: str  # its time over that of the cheapest ranked engine
    ours: bool


def advice(data: ReportData) -> list[Advice]:
    """Return a line for each engine, ours last: it is no part of the ranking."""
    return sorted((_of_engine(data, engine) for engine in data.engines), key=lambda line: line.ours)


def _of_engine(data: ReportData, engine: str) -> Advice:
    if engine in data.missing:
        return Advice(engine, "Not installed here: nothing is known of it.", "", "", (), "", engine == OURS)
    return Advice(
        engine, *_trust(data, engine), _limit(data, engine), _silent(data, engine), _pace(data, engine), engine == OURS
    )


def reached(data: ReportData, engine: str, target: float) -> dict[str, Record]:
    """Return the engine's cheapest run at a target, by scene."""
    runs = {scene: reaching(data, scene, engine, target) for scene in data.scenes}
    return {scene: own[0] for scene, own in runs.items() if own}


def _trust(data: ReportData, engine: str) -> tuple[str, str]:
    able = data.modelled(engine)
    if not able:
        return "It runs none of these scenes.", ""
    hits = {target: reached(data, engine, target) for target in TARGETS}
    reach = ", ".join(f"{short(target)} on {len(hits[target])}" for target in TARGETS)
    best = hits[MIDDLE] or hits[TARGETS[0]]
    if not best:
        return f"It comes within {short(TARGETS[0])} of the truth on none of {count(len(able), 'scene')}.", ""
    method, number = Counter(run.method for run in best.values()).most_common(1)[0]
    runs = [run for run in best.values() if run.method == method]
    within = MIDDLE if hits[MIDDLE] else TARGETS[0]
    wrong = {c.label for c in data.cells if (c.engine, c.method) == (engine, method) and c.verdict in SILENT}
    others = "".join(f", {run.method} on {scene}" for scene, run in best.items() if scene in wrong)
    use = f"Use {method} at {_span(runs)} for {short(within)}{others}: it is the cheapest of its methods on "
    use += f"{number} of {len(best)}."
    return use, f"Of {count(len(able), 'scene')} it models, it reaches {reach}."


def _span(runs: list[Record]) -> str:
    """Return the range of settings of some runs in words."""
    for key, name, unit in (("step", "h", " s"), ("rtol", "rtol", "")):
        values = [float(run.settings[key]) for run in runs if run.settings.get(key) is not None]
        if values:
            low, high = short(min(values)), short(max(values))
            return f"{name} = {low}{unit}" if low == high else f"{name} = {low} to {high}{unit}"
    return "its defaults"


MISSED = {
    "not-reached": "its own limit keeps it from {target} on {scenes}",
    "not-tried": "{target} would take more than {steps:,} steps, or more time than the report allows, on {scenes}",
    "cannot": "at no setting tried does it run to the end on {scenes}",
    "unjudged": "no truth judges {target} on {scenes}",
}


def _limit(data: ReportData, engine: str) -> str:
    """Return which scenes it does not solve to MIDDLE, and why."""
    able = data.modelled(engine)
    if not able:
        return ""
    answers = {scene: next(e.answer for e in entries(data, scene, MIDDLE) if e.engine == engine) for scene in able}
    parts = []
    for answer, sentence in MISSED.items():
        if where := ", ".join(scene for scene, own in answers.items() if own == answer):
            parts.append(sentence.format(target=short(MIDDLE), scenes=where, steps=MOST_STEPS))
    if cannot := ", ".join(scene for scene in data.scenes if scene not in able):
        parts.append(f"it cannot model {cannot}")
    return " ".join(f"{part[:1].upper()}{part[1:]}." for part in parts)


def _silent(data: ReportData, engine: str) -> tuple[str, ...]:
    """Return what the engine gets wrong with success reported, the worst first."""
    own = findings(data.only(engines=[engine]))
    return tuple(f"{one.title.removeprefix(engine).strip()}. {one.text.rstrip('.')}" for one in own if one.error)


def _pace(data: ReportData, engine: str) -> str:
    """Return its median time at MIDDLE over that of the cheapest ranked engine; empty where it is compared to none."""
    standing = next((one for one in standings(data, MIDDLE) if one.engine == engine), None)
    if standing is None or standing.median is None or set(data.engines) <= {engine, OURS}:
        return ""
    scenes = count(len(standing.factors), "scene")
    return f"{short(standing.median)} × the time of the cheapest ranked engine (median of {scenes})"


SECTION = Section("decisions", "What to use it for", lambda data: {"advice": advice(data)})
