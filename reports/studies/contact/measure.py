"""What contact does to methods and engines: order with and without events, restitution, the tracked vehicle."""

from __future__ import annotations

import numpy as np

from benchmarks.event_work import Balance, balance
from cross_checks import engines
from cross_checks.judge.one_run import judged_run
from cross_checks.truths.bouncing_ball import impact
from mbs_ref import scenes
from mbs_ref.observables.distance import farthest
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.facts.curves import Curves, curves, film
from reports.studies.contact.facts import ContactFacts, EngineBounce, OrderLadder, Restitution, VehicleRun

STEPS = (375, 750, 1500, 3000, 6000)  # over the ball's 0.4 s
LAWS = {
    "spring_damper": {}, "spring_damper_force": {}, "progressive": {"damping": 3e4},
    "hunt_crossley": {"stiffness": 1e6, "damping": 3e5}, "lankarani_nikravesh": {"stiffness": 1e6},
    "flores": {"stiffness": 1e6}, "rigid": {},
}  # fmt: skip
ENGINE_METHODS = (("mujoco", "rk4"), ("mujoco", "rk4_stock_contact"), ("exudyn", "contact_rk44"))
OFF_GRID = 0.1234567  # m, height: no whole number of steps, so that no engine meets gap = 0 at a step's end
VEHICLE_END, VEHICLE_SAMPLES = 2.0, 201
FILMED = 5  # samples a picture
VEHICLE_RUNS = (
    Settings(method="dop853", rtol=1e-8), Settings(method="rk4", step=1e-4, reactions=False),
    Settings(method="lsodar", rtol=1e-7, reactions=False),
)  # fmt: skip


def measure() -> ContactFacts:
    """Measure it; most of the time is the vehicle's."""
    vehicle = scenes.make("tracked_vehicle")
    paths, runs = vehicle_runs(vehicle)
    energy = balance(vehicle, Settings(method="dop853", rtol=1e-8, t_end=0.1, estimate="off"), longest=2e-4)
    return ContactFacts(
        orders=tuple(ladder(law, way) for law in ("spring_damper", "progressive") for way in ("none", "located")),
        restitutions=tuple(_restitution(law) for law in LAWS),
        engines=tuple(_bounce(*each) for each in ENGINE_METHODS if each[0] in engines.names()),
        runs=runs,
        description=vehicle.description,
        t_end=float(paths[0].times[-1]),
        film=film(vehicle, paths[0], FILMED),
        curves=vehicle_curves(vehicle, paths[0], energy),
        energy_end=float(energy.times[-1]),
        exchanged=energy.exchanged,
        drift=float(np.max(np.abs(energy.drift))),
    )


def vehicle_runs(vehicle: Scene) -> tuple[list[Trajectory], tuple[VehicleRun, ...]]:
    """Run the vehicle with each method; the first is what the others are compared with."""
    more = {"t_end": VEHICLE_END, "samples": VEHICLE_SAMPLES, "estimate": "off"}
    paths = [simulate(vehicle, settings.model_copy(update=more)) for settings in VEHICLE_RUNS]
    return paths, tuple(_vehicle_run(vehicle, s, p, paths[0]) for s, p in zip(VEHICLE_RUNS, paths, strict=True))


def _vehicle_run(vehicle: Scene, settings: Settings, path: Trajectory, first: Trajectory) -> VehicleRun:
    knob = f"step {settings.step:g} s" if settings.step else f"rtol {settings.rtol:g}"
    worst = 0.0 if path.step_compliance is None else float(np.max(path.step_compliance[:, 1]))
    return VehicleRun(
        f"{settings.method}, {knob}", path.steps, path.events, worst,
        farthest(vehicle, path, first)[0], path.timing.loop_s,
        str(path.status) if path.ok else path.message,
    )  # fmt: skip


def _ball(law: str) -> Scene:
    return scenes.make("bouncing_ball", law=law, **LAWS[law])


def ladder(law: str, events: str) -> OrderLadder:
    ball = _ball(law)
    exact = impact(ball.contacts[0].law, 1.0, 1.0).restitution
    settings = [Settings(method="rk4", step=0.4 / n, events=events, samples=2, estimate="off") for n in STEPS]  # type: ignore[arg-type]
    errors = tuple(abs(float(simulate(ball, each).velocity[-1, 0, 1]) - exact) for each in settings)
    return OrderLadder(law, events, STEPS, errors)


def _restitution(law: str) -> Restitution:
    ball = _ball(law)
    found = simulate(ball, Settings(method="dop853", rtol=1e-12, samples=2, estimate="off")).velocity[-1, 0, 1]
    nominal = getattr(ball.contacts[0].law, "restitution", None)
    return Restitution(law, nominal, impact(ball.contacts[0].law, 1.0, 1.0).restitution, float(found))


def _bounce(engine: str, method: str) -> EngineBounce:
    law = "spring_damper" if engine == "exudyn" else "spring_damper_force"
    ball = scenes.make("bouncing_ball", law=law, height=OFF_GRID)
    record, _ = judged_run(ball, engine, Settings(method=method, step=2e-4, samples=101))
    error = None if record.error is None else record.error.value
    return EngineBounce(engine, method, record.contact, error, record.message)


def vehicle_curves(scene: Scene, path: Trajectory, energy: Balance) -> dict[str, Curves]:
    """Return the histories of the vehicle: path and speed, slip, contact forces, track tension, compliance, energy."""
    t = path.times
    chassis, sprocket = scene.body_index("chassis"), scene.body_index("sprocket")
    rim = -path.angular_velocity[:, sprocket] * _pitch_radius(scene)
    speed = path.velocity[:, chassis, 0]
    ground = [part for part in scene.contacts if part.body_b == "ground"]
    teeth = [part for part in scene.contacts if part.body_b == "sprocket"]
    feet = np.sum([path.contacts[part.name][:, 2] for part in ground], axis=0)
    push = np.sum([path.contacts[part.name][:, 1] for part in ground], axis=0)
    driven = np.max([np.hypot(*path.contacts[part.name][:, 1:3].T) for part in teeth], axis=0)
    pins = [joint.name for joint in scene.joints if joint.name.startswith("pin")]
    tension = np.array([np.hypot(*path.reactions[name][:, :2].T) for name in pins])
    compliance = np.zeros((0, 2)) if path.step_compliance is None else path.step_compliance[1:]
    place = path.position[:, chassis] - path.position[0, chassis]
    return {
        "Path of the chassis": curves(t, {"x": place[:, 0], "y": place[:, 1]}, "displacement, m"),
        "Speed, and slip of the track": curves(
            t, {"chassis": speed, "sprocket's pitch circle": rim, "slip": rim - speed}, "m/s"
        ),
        "Ground forces": curves(t, {"normal, all feet": feet, "thrust, all feet": push}, "N"),
        "Largest force of a sprocket tooth": curves(t, {"tooth": driven}, "N"),
        "Track tension": curves(t, {"largest": tension.max(axis=0), "mean": tension.mean(axis=0)}, "N"),
        "Constraint compliance": curves(
            compliance[:, 0], {"dop853": compliance[:, 1]}, "largest |C|, m", log=True
        ),
        "Energy less the work done": curves(energy.times, {"energy less work": energy.drift}, "J"),
    }  # fmt: skip


def _pitch_radius(scene: Scene) -> float:
    return next(part.pitch_radius for part in scene.contacts if part.type == "pin_on_sprocket")
