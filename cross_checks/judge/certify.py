"""Certificates of truths, computed afresh and confirmed by the reference solver."""

import platform
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np

from cross_checks import engines
from cross_checks.judge import ladder
from cross_checks.judge.measure import gaps_as_none
from cross_checks.judge.one_run import evaluate
from cross_checks.truths import seek_truth, stored_poses
from cross_checks.truths.certificate import Certificate
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene

PACKAGES = ("numpy", "scipy")  # whose versions may matter; extended precision is the processor's


def certify(scene: Scene, confirm: bool = True) -> Certificate | NoTruth:
    """Compute the scene's truth afresh on the grid of judged runs and return its certificate, or why it has none."""
    times = ladder.grid(scene)
    truth = seek_truth(scene, times, afresh=True)
    if isinstance(truth, NoTruth):
        return truth
    by, to = _confirmation(scene) if confirm else ("", None)
    end = {name: gaps_as_none(place) for name, place in zip(scene.body_names, truth.position[-1], strict=True)}
    return Certificate(
        scene.name, dict(scene.parameters), float(times[-1]), len(times), truth.kind, truth.how, truth.uncertainty,
        truth.difference, end, by, to, datetime.now(UTC).strftime("%Y-%m-%d"), _versions(),
    )  # fmt: skip


def store_poses(scene: Scene) -> Path | None:
    """Compute the scene's truth afresh and store its poses where it is costly and not proven; return their file."""
    times = ladder.grid(scene)
    before = stored_poses.load(scene, times)
    if before is not None and before.kind == "proven":
        return stored_poses.file_of(scene)
    truth = seek_truth(scene, times, afresh=True)
    return stored_poses.save(scene, times, truth) if isinstance(truth, Truth) and truth.is_costly else None


def _confirmation(scene: Scene) -> tuple[str, float | None]:
    """Run the reference solver at its finest: it shares the scene's data with the truth, and no code of motion."""
    solver = engines.get("mbs_ref")
    fit = solver.able(scene)
    if not fit:
        return "the reference solver does not run it", None
    finest = ladder.rungs(fit[0], scene)[-1]
    record = evaluate(scene, solver.name, finest, ladder.grid(scene))
    by = f"{solver.name} {fit[0].name} {ladder.label(finest)}"
    if record.error is None:
        return f"{by} does not finish: {record.message}", None
    return by, record.at_most("position_error")


def _versions() -> dict[str, str]:
    digits = np.finfo(np.longdouble).precision
    versions = {name: version(name) for name in PACKAGES}
    return {"python": platform.python_version(), **versions, "extended precision": f"{digits} digits"}
