"""What planar and spatial loads share."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from cross_checks.engines.exudyn_.planar_model import Redundant
from cross_checks.workshop.prescribed import constant_value, factor
from mbs_ref.scene import Force, Torque


def add_load(model: Redundant, kind, marker: int, vector: list[float], load: Force | Torque, **options) -> None:
    constant = constant_value(load.factor)
    if constant is not None:
        model.mbs.AddLoad(kind(markerNumber=marker, loadVector=[constant * c for c in vector], **options))
        return
    signal = factor(load.factor)

    def scaled(mbs, t, unit) -> list[float]:
        return [signal.value(t) * c for c in unit]

    options["loadVectorUserFunction"] = scaled
    model.mbs.AddLoad(kind(markerNumber=marker, loadVector=vector, **options))
    model.notes += (f"load {load.name!r} calls Python at every residual",)


def pull_only(mbs, t, number, stretch, stretch_rate, stiffness, damping, force) -> float:
    return max(0.0, stiffness * stretch + damping * stretch_rate) if stretch > 0.0 else 0.0
