"""What contact does to methods and engines: order with and without events, restitution, the tracked vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.event_work import Balance, balance
from cross_checks import engines
from cross_checks.judge.one_run import judged_run
from cross_checks.truths.bouncing_ball import impact
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

STEPS = (375, 750, 1500, 3000, 6000)  # over the ball's 0.4 s
LAWS = {
    "spring_damper": {}, "spring_damper_force": {}, "progressive": {"damping": 3e4},
    "hunt_crossley": {"stiffness": 1e6, "damping": 3e5}, "lankarani_nikravesh": {"stiffness": 1e6},
    "flores": {"stiffness": 1e6}, "rigid": {},
}  # fmt: skip
ENGINE_METHODS = (("mujoco", "rk4"), ("mujoco", "rk4_stock_contact"), ("exudyn", "contact_rk44"))
OFF_GRID = 0.1234567  # m, height: no whole number of steps, so that no engine meets gap = 0 at a step's end
VEHICLE_END, VEHICLE_SAMPLES = 2.0, 201
VEHICLE_RUNS = (
    Settings(method="dop853", rtol=1e-8), Settings(method="rk4", step=1e-4, estimate="off"),
    Settings(method="lsodar", rtol=1e-7),
)  # fmt: skip


@dataclass(frozen=True)
class OrderLadder:
    """RK4 on the bouncing ball: error of the speed after the bounce."""

    law: str
    events: str
    steps: tuple[int, ...]
    errors: tuple[float, ...]  # m/s; the ball arrives at 1 m/s

    @property
    def order(self) -> float:
        """The slope over the whole ladder."""
        return math.log(self.errors[0] / self.errors[-1]) / math.log(self.steps[-1] / self.steps[0])


@dataclass(frozen=True)
class Restitution:
    """One law: what it is called, what it exactly returns, what a run returns."""

    law: str
    nominal: float | None
    exact: float
    found: float


@dataclass(frozen=True)
class EngineBounce:
    """The ball in another engine, judged from its poses."""

    engine: str
    method: str
    figures: dict[str, float]
    error: float | None  # m
    message: str


@dataclass(frozen=True)
class VehicleRun:
    """One method on the tracked vehicle."""

    setting: str
    steps: int
    events: int
    compliance: float  # m, largest over every step
    difference: float  # m, from the first run, over all bodies and samples
    loop_s: float
    status: str


@dataclass(frozen=True)
class ContactFacts:
    """All of it."""

    orders: tuple[OrderLadder, ...]
    restitutions: tuple[Restitution, ...]
    engines: tuple[EngineBounce, ...]
    vehicle: Scene
    path: Trajectory
    runs: tuple[VehicleRun, ...]
    energy: Balance


def measure() -> ContactFacts:
    """Measure it; about a minute, most of it the vehicle."""
    vehicle = scenes.make("tracked_vehicle")
    paths, runs = vehicle_runs(vehicle)
    return ContactFacts(
        orders=tuple(_ladder(law, way) for law in ("spring_damper", "progressive") for way in ("none", "located")),
        restitutions=tuple(_restitution(law) for law in LAWS),
        engines=tuple(_bounce(*each) for each in ENGINE_METHODS if each[0] in engines.names()),
        vehicle=vehicle,
        path=paths[0],
        runs=runs,
        energy=balance(vehicle, Settings(method="dop853", rtol=1e-8, t_end=0.1), longest=2e-4),
    )


def vehicle_runs(vehicle: Scene) -> tuple[list[Trajectory], tuple[VehicleRun, ...]]:
    """Run the vehicle with each method; the first is what the others are compared with."""
    more = {"t_end": VEHICLE_END, "samples": VEHICLE_SAMPLES}
    paths = [simulate(vehicle, settings.model_copy(update=more)) for settings in VEHICLE_RUNS]
    return paths, tuple(_vehicle_run(s, p, paths[0]) for s, p in zip(VEHICLE_RUNS, paths, strict=True))


def _vehicle_run(settings: Settings, path: Trajectory, first: Trajectory) -> VehicleRun:
    n = min(len(path.times), len(first.times))
    knob = f"step {settings.step:g} s" if settings.step else f"rtol {settings.rtol:g}"
    worst = 0.0 if path.step_compliance is None else float(np.max(path.step_compliance[:, 1]))
    return VehicleRun(
        f"{settings.method}, {knob}", path.steps, path.events, worst,
        float(np.max(np.abs(path.position[:n] - first.position[:n]))), path.timing.loop_s,
        str(path.status) if path.ok else path.message,
    )  # fmt: skip


def _ball(law: str) -> Scene:
    return scenes.make("bouncing_ball", law=law, **LAWS[law])


def _ladder(law: str, events: str) -> OrderLadder:
    ball = _ball(law)
    exact = impact(ball.contacts[0].law, 1.0, 1.0).restitution
    settings = [Settings(method="rk4", step=0.4 / n, events=events, samples=2, estimate="off") for n in STEPS]  # type: ignore[arg-type]
    errors = tuple(abs(float(simulate(ball, each).velocity[-1, 0, 1]) - exact) for each in settings)
    return OrderLadder(law, events, STEPS, errors)


def _restitution(law: str) -> Restitution:
    ball = _ball(law)
    found = simulate(ball, Settings(method="dop853", rtol=1e-12, samples=2)).velocity[-1, 0, 1]
    nominal = getattr(ball.contacts[0].law, "restitution", None)
    return Restitution(law, nominal, impact(ball.contacts[0].law, 1.0, 1.0).restitution, float(found))


def _bounce(engine: str, method: str) -> EngineBounce:
    law = "spring_damper" if engine == "exudyn" else "spring_damper_force"
    ball = scenes.make("bouncing_ball", law=law, height=OFF_GRID)
    record, _ = judged_run(ball, engine, Settings(method=method, step=2e-4, samples=101))
    error = None if record.error is None else record.error.value
    return EngineBounce(engine, method, record.contact, error, record.message)
