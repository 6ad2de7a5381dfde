"""mbs-ref inspect SCENE: numerical trouble seen in advance."""

from collections import Counter
from typing import Any

import click
import numpy as np

from mbs_ref.integrators import integrators
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.traits import traits
from mbs_ref.simulate.linearised import Stiffness, steady_motion_at_start, stiffness_at_start
from reports import inputs
from reports.console import compiling, echo_json, number, show_table
from reports.scene_summary import summary

SHOWN = 6  # eigenvalues
CONTACT = ("rule_", "impact_")  # beginnings of the quantities that a scene without contacts has not


@click.command(name="inspect", epilog="Example: mbs-ref inspect bouncing_ball")
@inputs.scene_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(scene: str, parameters: tuple[str, ...], keep_rates: tuple[str, ...], as_json: bool) -> None:
    """Linearise SCENE at its start: stiffness, steps and modes.

    A contact that can close is linearised where an impact at the scene's own speed is deepest, and its step is stated.
    """
    click.get_current_context().with_resource(compiling())
    chosen = inputs.scene(scene, parameters, keep_rates)
    speed = scales_of(chosen).speed
    results, steady = stiffness_at_start(chosen, speed), steady_motion_at_start(chosen)
    dominant = results.modes[np.argsort(-np.abs(results.modes))][:SHOWN]
    result: dict[str, Any] = {
        "scene": chosen.name,
        "summary": summary(chosen).sentence(),
        "traits": sorted(traits(chosen)),
        "breakpoints_s": chosen.breakpoints(),
        "contacts": len(chosen.contacts),
        "fastest_1_s": results.fastest,
        "fastest_decay_1_s": results.fastest_decay,
        "eigenvalues_1_s": [[value.real, value.imag] for value in dominant.tolist()],
        "rule_1_over_omega_s": _finite(results.oscillation_rule),
        "rule_m_over_c_s": _finite(results.damping_rule),
        "largest_step_s": _steps(results, chosen.duration),
        "impact_speed_m_s": speed,
        "closed_contacts": [
            {"stiffness_N_m": float(slope), "largest_step_s": _steps(results.of_contact(k), chosen.duration)}
            for k, slope in enumerate(results.contact_slopes)
        ],
        "steady_motion_1_s": steady.reason or [[value.real, value.imag] for value in steady.eigenvalues.tolist()],
    }
    if as_json:
        echo_json(result)
        return
    alike = Counter(_closed(contact, speed) for contact in result.pop("closed_contacts"))
    rows = [(name, _cell(value)) for name, value in result.items() if chosen.contacts or not name.startswith(CONTACT)]
    rows += [(f"{count} contact{'s' if count > 1 else ''}, closed", said) for said, count in alike.items()]
    show_table(f"{chosen.name} at t = 0", ("quantity", "value"), rows)  # the papers' rules are for contacts


def _steps(results: Stiffness, duration: float) -> dict[str, float | None]:
    """Return the largest stable step (s) of each explicit method; None where it is longer than the run."""
    known = {name: method.stability for name, method in integrators().items() if method.stability}
    limits = {name: results.step_limit(stability) for name, stability in known.items()}
    return {name: limit if limit < duration else None for name, limit in limits.items()}


def _closed(contact: dict[str, Any], speed: float) -> str:
    """Return what the step is limited to while a contact is closed."""
    if not contact["stiffness_N_m"]:
        return "impulses or a constraint act, and stability limits no step"
    at = f"at {number(contact['stiffness_N_m'])} N/m (impact at {number(speed)} m/s)"
    return f"{at} the step after contact is at most {_cell(contact['largest_step_s'])}"


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name} {_cell(item)}" for name, item in value.items())
    if isinstance(value, list) and value and isinstance(value[0], list):
        text = dict.fromkeys((number(real), number(abs(imaginary))) for real, imaginary in value)
        return ", ".join(real if imaginary == "0" else f"{real} ± {imaginary}i" for real, imaginary in text)
    if isinstance(value, list):
        return ", ".join(_cell(item) for item in value) or "none"
    if isinstance(value, float):
        return number(value)
    return "not limited by stability" if value is None else str(value)
