"""Resolve settings against a scene and an integrator: output times, tolerances, combinations that are refused."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mbs_ref.cores.choice import core_name, state_units
from mbs_ref.cores.events import event_sources
from mbs_ref.integrators import DEFAULT, integrators
from mbs_ref.integrators.loop.events import event_code
from mbs_ref.integrators.loop.explicit import between_code
from mbs_ref.integrators.loop.leg import Integrator, Options
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.traits import Coordinates, deflecting, traits
from mbs_ref.settings import Settings

DEFAULT_TOLERANCE = 1e-8  # rtol
# atol / rtol over the scene's unit of each coordinate: a decade below the scale of a motion, because most coordinates
# pass zero. In scenes of 0.1 to 10 m this is no looser than 1 m, rad, m/s, rad/s.
ABSOLUTE = 0.1
PROJECTION_TOLERANCE = 1e-14  # times the scene's size in metres (at least 1 m): a little above roundoff
CHUNK = 20_000  # steps between two checks for Ctrl-C
MAX_EVENTS = 1_000_000  # located in one run
ON_GRID = 1e-9  # of a step: how far an output time may be from a multiple of the step


@dataclass(frozen=True)
class Plan:
    """Settings resolved against a scene and an integrator."""

    integrator: Integrator
    settings: Settings
    times: np.ndarray  # (n_t,) s
    options: Options
    baumgarte_gain: float
    notes: tuple[str, ...]
    reason: str = ""  # why this method, if mbs_ref chose it


def integration_options(scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Options:
    """Return the options that `simulate` passes to its integrator; benchmarks of the bare integrator use it."""
    return make_plan(scene, settings, times).options


def make_plan(scene: Scene, settings: Settings, times: np.ndarray | None) -> Plan:
    """Return settings resolved against a scene; ValueError for an unknown method or contradictory settings."""
    known = integrators()
    name = settings.method or DEFAULT
    if name not in known:
        raise ValueError(f"method = {name!r} is unknown to mbs_ref; allowed: {', '.join(known)}")
    integrator = known[name]
    missing = integrator.requires and integrator.requires - traits(scene)
    if missing:
        raise ValueError(f"method = {name!r} needs a scene that is {', '.join(sorted(missing))}; {scene.name!r} is not")
    reasons = [reason for reason, _ in obstacles(scene, integrator, settings.coordinates)]
    if reasons:
        raise ValueError(f"method = {name!r} cannot run {scene.name!r}: {'; '.join(reasons[:8])}")
    fixed = _wants_fixed_step(integrator, settings)
    lands = fixed and settings.outputs == "landed"
    notes: tuple[str, ...] = ()
    if times is None:
        t_end = settings.t_end if settings.t_end is not None else scene.duration
        times = _even_grid(t_end, settings.samples, settings.step if lands else None)
    times = _checked_times(times)
    if lands and settings.step is not None:
        notes = _off_grid_notes(times, settings.step)
    stabilization = settings.stabilization or integrator.stabilization
    if stabilization not in integrator.stabilizations:
        allowed = ", ".join(integrator.stabilizations)
        raise ValueError(f"stabilization = {stabilization!r} does not go with method {name!r}; allowed: {allowed}")
    if settings.coordinates == "relative" and stabilization == "baumgarte":
        raise ValueError("stabilization = 'baumgarte' has no effect in relative coordinates: they have no rows")
    if settings.outputs == "dense" and not integrator.interpolates:
        allowed = ", ".join(name for name, entry in known.items() if entry.interpolates)
        raise ValueError(f"outputs = 'dense': method {name!r} has no interpolant of its order; allowed: {allowed}")
    _check_events(scene, settings, integrator)
    rtol, scales = settings.rtol or DEFAULT_TOLERANCE, scales_of(scene)
    units = state_units(scene, scales, settings.coordinates)
    size = max([1.0, *(abs(x) for body in scene.bodies for x in body.position)])
    settle, watch = event_code() if event_sources(scene) else (0, 0)
    options = Options(
        step=float(settings.step or 0.0) if fixed else 0.0, rtol=float(rtol),
        atol=np.full_like(units, settings.atol) if settings.atol else rtol * ABSOLUTE * units, units=units,
        time=scales.time, project=stabilization == "projection", stop_on_compliance=settings.stop_on_compliance,
        max_steps=settings.max_steps, max_events=min(MAX_EVENTS, settings.max_steps),
        projection_tolerance=PROJECTION_TOLERANCE * size, chunk=CHUNK, dense=settings.outputs == "dense",
        settle=settle, watch=watch, between=between_code() if settings.outputs == "dense" else 0,
    )  # fmt: skip
    gain = settings.baumgarte_gain if stabilization == "baumgarte" else 0.0
    return Plan(integrator, settings, times, options, gain, notes)


def obstacles(
    scene: Scene, integrator: Integrator, coordinates: Coordinates = "cartesian"
) -> Iterator[tuple[str, bool]]:
    """Yield why a method cannot run a scene, and whether its equations forbid it; traits that it requires are apart."""
    if integrator.needs_positions and "nonholonomic" in traits(scene):
        yield "a rolling wheel has constraints on velocities alone, and this method needs C = 0 on positions", True
    core = core_name(scene, coordinates)
    if integrator.cores and core not in integrator.cores:
        yield f"it is for {', '.join(integrator.cores)} scenes; this one is {core}", True
    if not integrator.holds_deflections and (extra := deflecting(scene)):
        named = ", ".join(map(repr, extra[:8]))
        yield f"contacts {named} stick in space: their deflections are states, which this method does not carry", False
    yield from ((reason, False) for reason in integrator.refusals(scene))


def _check_events(scene: Scene, settings: Settings, integrator: Integrator) -> None:
    if settings.events == "none" and scene.events:
        raise ValueError(f"events = 'none' cannot run {scene.events[0].name}: a declared event must be located")
    if (scene.contacts or scene.events) and settings.events != "none" and not integrator.locates_events:
        raise ValueError(f"method {integrator.name!r} locates no events; give events = 'none', or another method")
    if settings.events != "none":
        return
    needs = [c.name for c in scene.contacts if c.law.IMPULSIVE or (c.friction and c.friction.STICKS)]
    if needs:
        raise ValueError(f"events = 'none' cannot run {', '.join(needs[:8])}: impacts and sticking are events")
    needs = [c.name for c in scene.contacts if c.law.NEEDS_IMPACT_SPEED]
    if needs:
        raise ValueError(f"events = 'none' cannot run {', '.join(needs[:8])}: the law needs the speed at touch-down")


def _wants_fixed_step(integrator: Integrator, settings: Settings) -> bool:
    if integrator.kind == "fixed" and settings.step is None:
        raise ValueError(f"method {integrator.name!r} has a fixed step; give step (s), not tolerances")
    if integrator.kind == "adaptive" and settings.step is not None:
        raise ValueError(f"method {integrator.name!r} is adaptive; give rtol and atol, not step = {settings.step}")
    return settings.step is not None


def _even_grid(t_end: float, samples: int, step: float | None) -> np.ndarray:
    if step is None:
        return np.linspace(0.0, t_end, samples)
    whole = int(np.floor(t_end / step * (1.0 + ON_GRID)))
    picks = np.unique(np.linspace(0, whole, min(samples, whole + 1)).round().astype(int))
    times = picks * step
    if t_end - times[-1] > ON_GRID * step:
        return np.append(times, t_end)
    times[-1] = t_end
    return times


def _checked_times(times: np.ndarray) -> np.ndarray:
    times = np.asarray(times, dtype=float)
    if times.ndim != 1 or len(times) < 2 or times[0] != 0.0 or not (times[1:] > times[:-1]).all():
        raise ValueError(f"times must start at 0 and increase, with two entries at least; got {times!r}")
    if not np.isfinite(times[-1]):
        raise ValueError("times must be finite")
    return times


def _off_grid_notes(times: np.ndarray, step: float) -> tuple[str, ...]:
    ratio = times / step
    off = np.abs(ratio - ratio.round()) > ON_GRID * np.maximum(1.0, ratio)
    if not off.any():
        return ()
    first = times[off][0]
    return (f"{off.sum()} of {len(times)} output times are no multiple of the step {step:g} s (first: {first:g} s); "
            "the last step before each is shorter",)  # fmt: skip
