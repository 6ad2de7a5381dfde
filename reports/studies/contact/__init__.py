"""What contact does to methods and engines: order with and without events, restitution, the tracked vehicle."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import partial

import numpy as np

from cross_checks.contact import models
from cross_checks.contact.by_figure import Obtained, compare, with_contact
from cross_checks.contact.tosses import Summary, predict, stored, summaries
from cross_checks.judge.vocabulary import OURS
from cross_checks.truths.of.bouncing import impact
from mbs_ref import Scene, Settings, Trajectory, scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.energy import is_conservative, kinetic_energy, potential_energy
from mbs_ref.observables.powers import powers
from mbs_ref.simulate import simulate
from reports.facts.curves import Curves, Measured, Row, Value, curves, film, plain
from reports.studies.crash import finished

STEPS = (375, 750, 1500, 3000, 6000)  # over the ball's 0.4 s
LAWS = {
    "spring_damper": {}, "spring_damper_force": {}, "progressive": {"damping": 3e4},
    "hunt_crossley": {"stiffness": 1e6, "damping": 3e5}, "lankarani_nikravesh": {"stiffness": 1e6},
    "flores": {"stiffness": 1e6}, "rigid": {},
}  # fmt: skip
ENGINES_STEP, TOSSES_STEP = 5e-4, 1e-4  # s
FEW_TOSSES = 4  # one of so many is predicted, unless all are
VEHICLE_END, VEHICLE_SAMPLES = 2.0, 201
NOMINAL = 1e-3  # difference from the nominal restitution above which a law does not return it
FILMED = 5  # samples a picture
VEHICLE_RUN = Settings(method="dop853", rtol=1e-8, t_end=VEHICLE_END, samples=VEHICLE_SAMPLES, estimate="off")


def parts() -> list[tuple[str, ...]]:
    """Return the parts by what they measure: tosses by an engine take longest."""
    tossed = [("tosses", engine) for engine in (OURS, *models()[0])]
    return [*tossed, ("vehicle",), ("laws",), *(("engines", scene) for scene in with_contact())]


def measure_part(part: tuple[str, ...], full: bool = False) -> Measured:
    """Measure a part; most of the time is the engines'. With `full` all tosses are predicted."""
    kind, *about = part
    tosses = partial(_tosses, full=full)
    return {"tosses": tosses, "vehicle": _vehicle, "laws": _laws, "engines": _engines}[kind](*about)


def _tosses(engine: str, full: bool) -> Measured:
    tosses = stored()
    shown = tosses if full else tosses[::FEW_TOSSES]
    predicted = predict(shown, models()[0], TOSSES_STEP, engine=engine)
    figures: dict[str, Value] = {"tosses.shown": len(shown), "tosses.stored": len(tosses)}
    return Measured(figures, {"tosses": tuple(_of_tosses(one) for one in summaries(predicted))})


def _engines(name: str) -> Measured:
    found = compare(models()[0], {name: scenes.make(name)}, ENGINES_STEP)
    return Measured(tables={"engines": tuple(_by_engine(one) for one in found)})


def _laws() -> Measured:
    orders = tuple(ladder(law, way) for law in ("spring_damper", "progressive") for way in ("none", "located"))
    figures = {f"order.{row['law']}.{row['events']}": row["order"] for row in orders}
    drawn = {f"order: {row['law']}, events {row['events']}": _line(row) for row in orders}
    return Measured(figures, {"orders": orders, "restitutions": tuple(_restitution(law) for law in LAWS)}, drawn)


def _vehicle() -> Measured:
    vehicle = scenes.make("tracked_vehicle")
    path = finished(vehicle, VEHICLE_RUN)
    energy = balance(vehicle, Settings(method="dop853", rtol=1e-8, t_end=0.1, estimate="off"), longest=2e-4)
    figures: dict[str, Value] = {
        "vehicle.description": vehicle.description, "vehicle.t_end": float(path.times[-1]),
        "vehicle.energy_end": float(energy.times[-1]), "vehicle.exchanged": energy.exchanged,
        "vehicle.drift": float(np.max(np.abs(energy.drift))),
    }  # fmt: skip
    drawn = {f"vehicle: {name}": lines for name, lines in vehicle_curves(vehicle, path, energy).items()}
    return Measured(figures, {}, drawn, {"vehicle": film(vehicle, path, FILMED)})


def _by_engine(one: Obtained) -> Row:
    """Return a row of one figure; a reason takes the place of the figures."""
    row = asdict(one)
    if one.figure:
        return row | ({"obtained": one.reason} if one.reason else {})
    return row | dict.fromkeys(("requested", "uncertainty", "obtained", "change"), "") | {"figure": one.reason}


def _of_tosses(one: Summary) -> Row:
    """Return a row of one model; its reason takes the place of what no toss shows."""
    return asdict(one) | ({"error": one.reason, "share": ""} if one.error is None else {})


def _line(row: Row) -> Curves:
    """Return the errors of a ladder over its steps."""
    errors = plain([row[str(n)] for n in STEPS])
    label, axis = "error of the speed after the bounce, m/s", "steps over 0.4 s"
    return Curves(plain(STEPS), {"error": errors}, label, axis, log=True, x_log=True, marks="lines+markers")


def _ball(law: str) -> Scene:
    return scenes.make("bouncing_ball", law=law, **LAWS[law])


def ladder(law: str, events: str) -> Row:
    """Return the errors (m/s) of the speed after a bounce at 1 m/s by the number of RK4 steps, and their order."""
    ball = _ball(law)
    exact = impact(ball.contacts[0].law, 1.0, 1.0).restitution
    settings = [Settings(method="rk4", step=0.4 / n, events=events, samples=2, estimate="off") for n in STEPS]  # type: ignore[arg-type]
    errors = [abs(float(simulate(ball, each).velocity[-1, 0, 1]) - exact) for each in settings]
    order = math.log(errors[0] / errors[-1]) / math.log(STEPS[-1] / STEPS[0])
    return {"law": law, "events": events, "order": order, **{str(n): e for n, e in zip(STEPS, errors, strict=True)}}


def _restitution(law: str) -> Row:
    """Return a law's nominal restitution, the exact one and that of a run."""
    ball = _ball(law)
    path = simulate(ball, Settings(method="dop853", rtol=1e-12, samples=2, estimate="off"))
    computed, exact = float(path.velocity[-1, 0, 1]), impact(ball.contacts[0].law, 1.0, 1.0).restitution
    nominal = getattr(ball.contacts[0].law, "restitution", None)
    note = "" if nominal is None or abs(nominal - exact) <= NOMINAL else ", not returned"
    return {
        "law": law, "nominal": nominal, "note": note, "exact": exact, "computed": computed,
        "difference": abs(computed - exact),
    }  # fmt: skip


def vehicle_curves(scene: Scene, path: Trajectory, energy: Balance) -> dict[str, Curves]:
    """Return the histories of the vehicle: path and speed, slip, contact forces, track tension, compliance, energy."""
    t = path.times
    chassis, sprocket = scene.body_index("chassis"), scene.body_index("sprocket")
    rim = -path.angular_velocity[:, sprocket] * next(
        part.pitch_radius for part in scene.contacts if part.type == "pin_on_sprocket"
    )
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
        "Constraint compliance": curves(compliance[:, 0], {"dop853": compliance[:, 1]}, "largest |C|, m", log=True),
        "Energy less the work done": curves(energy.times, {"energy less work": energy.drift}, "J"),
    }


POINTS = 3  # of Gauss and Legendre in a panel: exact for a power of degree 5
APART = 1e-9  # s: events closer than this share a panel's edge


@dataclass(frozen=True)
class Balance:
    """Energy and work at the edges of the panels."""

    times: np.ndarray  # (n,) s
    energy: np.ndarray  # (n,) J, kinetic + potential
    work: np.ndarray  # (n,) J, since t = 0, of contacts, dampers and drives
    exchanged: float  # J, the integral of |power|: what the drift is to be compared with

    @property
    def drift(self) -> np.ndarray:
        return self.energy - self.energy[0] - self.work


def balance(scene: Scene, settings: Settings, longest: float) -> Balance:
    """Run twice and balance the energy; panels are `longest` (s) at most. RuntimeError where a run fails."""
    run = finished(scene, settings.model_copy(update={"reactions": False}))
    end = float(run.times[-1])
    events = np.zeros(0) if run.event_times is None else run.event_times[:, 0]
    cuts = np.concatenate((events, scene.breakpoints(), np.linspace(0.0, end, int(np.ceil(end / longest)) + 1)))
    cuts = np.unique(cuts[(cuts > APART) & (cuts < end - APART)])
    stored = cuts[np.concatenate(([True], np.diff(cuts) > APART))] if len(cuts) else cuts
    edges = np.concatenate(([0.0], stored, [end]))
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    width = np.diff(edges)
    inside = edges[:-1, None] + 0.5 * width[:, None] * (1.0 + points)
    every = np.unique(np.concatenate((edges, inside.ravel())))
    path = finished(scene, settings.model_copy(update={"reactions": True}), every)  # with contact forces
    power = powers(Motion(scene, path), is_conservative)
    if power is None:
        power = np.zeros(len(path.times))
    at = np.searchsorted(path.times, inside)
    steps = 0.5 * width * (power[at] @ weights)
    energy = (kinetic_energy(scene, path) + potential_energy(scene, path))[np.searchsorted(path.times, edges)]
    exchanged = float(np.sum(0.5 * width * (np.abs(power[at]) @ weights)))
    return Balance(edges, energy, np.concatenate(([0.0], np.cumsum(steps))), exchanged)
