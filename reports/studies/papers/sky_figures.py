"""The planets of the second paper by its own methods: significant figures after 200 and 360 days, and compliance."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.judge.one_run import evaluate
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

DAYS = (200.0, 360.0)
DAY = 86_400.0  # s
OBSERVED = NoTruth("held against where the bodies really were")
METHODS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("euler", {"step": 0.1 * DAY}), ("rk4", {"step": DAY}), ("lsodar", {"rtol": 1e-9}), ("dop853", {"rtol": 1e-12}),
)  # fmt: skip
RIGID: dict[str, Any] = {"formulation": "euler_parameters", "spin": True}


def measure_sky() -> dict[str, float | str]:
    """Return the figures of all bodies' least exact one, and |theta^T theta - 1|."""
    figures: dict[str, float | str] = {}
    for days in DAYS:
        for method, more in METHODS:
            settings = Settings(method=method, samples=2, estimate="off", max_steps=10**6, **more)
            figures[f"sky.{method}.{days:g}"] = _figures("lumped", days, settings)
        for model in ("lumped", "full"):
            figures[f"sky.{model}.{days:g}"] = _figures(model, days, Settings(method="gauss", rtol=1e-16, samples=2))
    for stabilization in ("none", "projection"):
        scene = scenes.make("solar_system", model="newton", days=DAYS[1], **RIGID)
        path = simulate(scene, Settings(method="dop853", rtol=1e-12, samples=2, stabilization=stabilization))
        norm = np.linalg.norm(path.orientation[-1], axis=1)
        figures[f"sky.norm.{stabilization}"] = float(np.abs(norm**2 - 1.0).max())
    return figures


def _figures(model: str, days: float, settings: Settings) -> float | str:
    record = evaluate(scenes.make("solar_system", model=model, days=days), "mbs_ref", settings, truth=OBSERVED)
    return min(record.figures.values()) if record.status == "success" else record.message
