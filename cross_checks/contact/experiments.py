"""Experiments that measure a contact: a free impact, a body at rest on a slope, and a body that slides to rest."""

import math
from typing import NamedTuple

import numpy as np

from cross_checks.contact import request as wanted
from cross_checks.contact.request import GRAVITY, ContactModel, Request, Translation
from cross_checks.judge.one_run import checked_run
from cross_checks.metrics.contact_figures import contact_figures
from mbs_ref.scene import GROUND, PlanarBody, Scene
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory

RADIUS = 0.1  # m
UNTURNED = 1e9  # kg m^2: a body of this inertia slides without turning
FLIGHT = 12.37  # steps of free flight before an impact, no whole number
HELD, RESTS = 1.0, 1.0  # s on the slope, and after sliding


class Measured(NamedTuple):
    """One requested figure, as an engine obtains it."""

    figure: str
    requested: float
    obtained: float | None
    note: str  # what the engine's documentation excludes, or why its run has no figure


def measured(model: ContactModel, request: Request, translation: Translation) -> list[Measured]:
    """Return every requested figure as the engine obtains it at the requested step."""
    experiments = [impact_scene(request, translation)]
    if translation.friction is not None:
        angle, slides = math.atan(wanted.SHARE * request.friction), request.speed / (request.friction * GRAVITY)
        experiments.append(floor_scene(request, translation, 0.0, request.speed, slides + RESTS))
        experiments.append(floor_scene(request, translation, angle, 0.0, HELD))
    figures: dict[str, float] = {}
    failures: list[str] = []
    for scene in experiments:
        path = run(model, model.compared[0], scene, request.step)
        if isinstance(path, str):
            failures.append(path)
            continue
        shown = {name.removeprefix("pair: "): value for name, value in contact_figures(scene, path).items()}
        figures = shown | figures
    return [_row(label, request, figures, translation, failures) for label in request.figures]


def _row(label: str, request: Request, figures: dict, translation: Translation, failures: list[str]) -> Measured:
    refused = translation.refused.get(label)
    notes = [f"cannot, {refused.instead:.3g} instead: {refused.why}"] if refused else []
    notes += failures if label not in figures else []
    return Measured(label, request.figures[label], figures.get(label), "; ".join(notes))


def run(model: ContactModel, method: str, scene: Scene, step: float) -> Trajectory | str:
    """Return the motion at every step, or the sentence why there is none."""
    settings = Settings(method=method, step=step, reactions=False, initial_tolerance=1.0)
    path = checked_run(model.engine, scene, settings, step * np.arange(round(scene.duration / step) + 1))
    if not isinstance(path, Trajectory):
        return path[1]
    return path if path.ok else path.message


def impact_scene(request: Request, translation: Translation) -> Scene:
    """Return a sphere that hits another one, fixed to the ground, without gravity."""
    centre = (0.0, 2.0 * RADIUS + FLIGHT * request.step * request.speed)
    ball = PlanarBody(name="ball", mass=request.mass, inertia=UNTURNED, position=centre, velocity=(0.0, -request.speed))
    pair = CircleOnCircle(
        name="pair", body_a="ball", center_a=centre, radius_a=RADIUS, body_b=GROUND, center_b=(0.0, 0.0),
        radius_b=RADIUS, law=translation.law,
    )  # fmt: skip
    steps = 3.0 * FLIGHT + 2.0 * request.figures[wanted.DURATION] / request.step
    return Scene(name="impact", duration=math.ceil(steps) * request.step, bodies=(ball,), contacts=(pair,))


def floor_scene(request: Request, translation: Translation, angle: float, speed: float, duration: float) -> Scene:
    """Return a body that cannot turn, sunk as the engine lets it, on a slope (rad) along its axes, at a speed (m/s)."""
    gravity = (GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle))
    refused = translation.refused.get(wanted.SINK)
    sink = refused.instead if refused else request.figures[wanted.SINK]
    centre = (0.0, RADIUS - math.cos(angle) * sink)
    body = PlanarBody(name="slider", mass=request.mass, inertia=UNTURNED, position=centre, velocity=(speed, 0.0))
    pair = CircleOnLine(
        name="pair", body_a="slider", center=centre, radius=RADIUS, point_1=(0.0, 0.0), point_2=(1.0, 0.0),
        law=translation.floor or translation.law, friction=translation.friction,
    )  # fmt: skip
    steps = math.ceil(duration / request.step)
    return Scene(name="slider", duration=steps * request.step, gravity=gravity, bodies=(body,), contacts=(pair,))
