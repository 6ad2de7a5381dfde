"""Contact: what jumps and kinks do to methods, what the laws return, and the tracked vehicle of Fox 2001."""

from __future__ import annotations

import base64
from dataclasses import replace
from typing import Any

import numpy as np

from reports.film import filmstrip, gif
from reports.page.plots.figure import new_figure, to_data
from reports.page.report_data import ReportData
from reports.page.section import Section
from reports.studies.contact.measure import ContactFacts

LEAD = (
    "A contact force jumps or bends where bodies touch and part. A step across such a place costs a method its order; "
    "with the place located and the contact's mode frozen inside each step the order comes back."
)
FILMED = 5  # samples a picture


def context(data: ReportData) -> dict[str, Any]:
    facts = data.contact
    if facts is None:
        return {"contact": None}
    return {
        "contact": facts,
        "order_plot": _orders(facts),
        "plots": vehicle_plots(facts),
        "gif": _data_uri("gif", gif(facts.vehicle, _every(facts))),
        "strip": _data_uri("png", filmstrip(facts.vehicle, _every(facts))),
        "drift": float(np.max(np.abs(facts.energy.drift))),
        "energy_end": float(facts.energy.times[-1]),
    }


def _orders(facts: ContactFacts) -> dict[str, Any]:
    figure = new_figure("steps over 0.4 s", "error of the speed after the bounce, m/s")
    for ladder in facts.orders:
        figure.add_scatter(
            x=list(ladder.steps), y=[max(e, 1e-17) for e in ladder.errors], mode="lines+markers",
            name=f"{ladder.law}, events {ladder.events}", line={"dash": "dot" if ladder.events == "none" else "solid"},
        )  # fmt: skip
    return to_data(figure)


def vehicle_plots(facts: ContactFacts) -> dict[str, dict[str, Any]]:
    """Return the histories of the vehicle: path and speed, slip, contact forces, track tension, compliance, energy."""
    scene, path = facts.vehicle, facts.path
    t = path.times
    chassis, sprocket = scene.body_index("chassis"), scene.body_index("sprocket")
    rim = -path.angular_velocity[:, sprocket] * _pitch_radius(facts)
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
        "Path of the chassis": _plot("t, s", "displacement, m", t, {"x": place[:, 0], "y": place[:, 1]}),
        "Speed, and slip of the track": _plot(
            "t, s", "m/s", t, {"chassis": speed, "sprocket's pitch circle": rim, "slip": rim - speed}
        ),
        "Ground forces": _plot("t, s", "N", t, {"normal, all feet": feet, "thrust, all feet": push}),
        "Largest force of a sprocket tooth": _plot("t, s", "N", t, {"tooth": driven}),
        "Track tension": _plot("t, s", "N", t, {"largest": tension.max(axis=0), "mean": tension.mean(axis=0)}),
        "Constraint compliance": _plot(
            "t, s", "largest |C|, m", compliance[:, 0], {"dop853": np.maximum(compliance[:, 1], 1e-17)}, log=True
        ),
        "Energy balance": _plot(
            "t, s", "J", facts.energy.times[::20],
            {"energy": (facts.energy.energy - facts.energy.energy[0])[::20], "work": facts.energy.work[::20]},
        ),
    }  # fmt: skip


def _pitch_radius(facts: ContactFacts) -> float:
    return next(part.pitch_radius for part in facts.vehicle.contacts if part.type == "pin_on_sprocket")


def _plot(x: str, y: str, times: np.ndarray, series: dict[str, np.ndarray], log: bool = False) -> dict[str, Any]:
    figure = new_figure(x, y, x_log=False, y_log=log)
    for name, values in series.items():
        figure.add_scatter(x=times.tolist(), y=values.tolist(), mode="lines", name=name)
    return to_data(figure)


def _every(facts: ContactFacts):
    fields = ("times", "position", "orientation", "velocity", "angular_velocity")
    return replace(facts.path, **{name: getattr(facts.path, name)[::FILMED] for name in fields})


def _data_uri(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


SECTION = Section("contact", "Contact", LEAD, context, template="contact/section.html")
