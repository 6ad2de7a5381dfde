"""One run, judged: (scene, engine, settings) -> Record. An engine's failure is an answer, not an exception."""

import platform
import re
from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.engine import Engine, output_times
from cross_checks.judge.measure import measure
from cross_checks.metrics.metric import Judged
from cross_checks.records.record import CANNOT, MISSING, Record, out_of_memory
from cross_checks.truths import seek_truth
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Settings, Status, Trajectory

ON_TIME = 1e-9  # s; a sample further from its requested time is a skipped or restarted clock
# What native engines raise when a run goes wrong. A TypeError or AttributeError is a broken adapter: it propagates.
ENGINE_FAILURES = (ArithmeticError, RuntimeError, MemoryError, OSError, LookupError, np.linalg.LinAlgError)


def evaluate(
    scene: Scene, engine: str, settings: Settings, times: np.ndarray | None = None, truth: Truth | NoTruth | None = None
) -> Record:
    """Return the record of `judged_run`; Ctrl-C ends what the run is part of."""
    return complete(judged_run(scene, engine, settings, times, truth=truth))[0]


def complete(judged: tuple[Record, Trajectory | None]) -> tuple[Record, Trajectory | None]:
    """Return what was judged; KeyboardInterrupt where Ctrl-C left a part of it."""
    if judged[0].status == Status.INTERRUPTED:
        raise KeyboardInterrupt(judged[0].message)
    return judged


def judged_run(
    scene: Scene, engine_name: str, settings: Settings, times: np.ndarray | None = None, *,
    truth: Truth | NoTruth | None = None, reference: Trajectory | None = None,
) -> tuple[Record, Trajectory | None]:  # fmt: skip
    """Run the scene and judge it; return the record and the trajectory's finite samples, None where nothing ran.

    Refusals, missing packages and failures are statuses with a sentence. `truth` is sought unless given; `reference`
    gives reaction forces to compare with. ValueError only where the engine or its method is unknown, or the scene
    itself cannot be sampled.
    """
    try:
        engine = engines.get(engine_name)
    except engines.EngineMissing as error:
        return without_run(scene, engine_name, settings, MISSING, str(error)), None
    method = engine.method(settings.method)
    settings = settings.model_copy(update={"method": method.name})
    if refusal := engine.refusal(scene, method):
        return without_run(scene, engine_name, settings, CANNOT, refusal, engine), None
    requested = output_times(scene, settings, times)
    outcome = checked_run(engine, scene, settings, requested)
    if not isinstance(outcome, Trajectory):
        return without_run(scene, engine_name, settings, *outcome, engine), None
    against = seek_truth(scene, requested) if truth is None else truth
    return record_of(engine, settings, Judged(scene, outcome, against, reference)), outcome


def checked_run(
    engine: Engine, scene: Scene, settings: Settings, requested: np.ndarray
) -> Trajectory | tuple[str, str]:
    """Run and check what the engine does not report; a status and a sentence where nothing came back."""
    try:
        path = engine.run(scene, settings, requested)
    except MemoryError as error:
        return "out-of-memory", f"{out_of_memory(error)}, and repeat"
    except ENGINE_FAILURES as error:
        return str(Status.ENGINE_ERROR), f"{type(error).__name__}: {error}"
    except ValueError as error:  # one that names a setting refuses it (duty 7 of an engine); any other is a failure
        named = any(re.search(rf"\b{name}\b", str(error)) for name in (*Settings.model_fields, "times"))
        return (CANNOT, str(error)) if named else (str(Status.ENGINE_ERROR), f"ValueError: {error}")
    return _on_time(_finite(path), requested)


def _finite(path: Trajectory) -> Trajectory:
    """Cut the trajectory before its first NaN or infinity."""
    parts = (path.position, path.orientation, path.velocity, path.angular_velocity)
    flat = [part.reshape(len(path.times), int(np.prod(part.shape[1:]))) for part in parts]  # maybe no samples at all
    good = np.all(np.isfinite(np.concatenate([path.times[:, None], *flat], axis=1)), axis=1)
    if np.all(good):
        return path
    count = int(np.argmin(good))
    cut = path.at(slice(count))
    if not path.ok:
        return cut
    where = f"after t = {path.times[count - 1]:.6g} s" if count else "from the start"
    text = f"NaN or infinity {where}, though the engine reported success"
    return replace(cut, status=Status.NON_FINITE, message=text, unreported=True)


def _on_time(path: Trajectory, requested: np.ndarray) -> Trajectory:
    """Find restarted clocks and missing samples behind a reported success."""
    n = len(path.times)
    if path.status is Status.STOP_EVENT:  # its last sample is where a declared event stopped it
        requested = np.append(requested[: n - 1], path.times[-1])
    late = np.abs(path.times - requested[:n]) > ON_TIME if n <= len(requested) else np.ones(n, bool)
    if np.any(late):
        k = int(np.argmax(late))
        text = f"sample {k} is at t = {path.times[k]:.9g} s, which was not requested: the engine's clock jumped"
        return replace(path.at(slice(k)), status=Status.RESET, message=text, unreported=True)
    if path.ok and n < len(requested):
        text = f"{n} of {len(requested)} samples came back, though the engine reported success"
        return replace(path, status=Status.ENGINE_ERROR, message=text, unreported=True)
    return path


def record_of(engine: Engine, settings: Settings, judged: Judged) -> Record:
    """Return the record of a run that came back."""
    scene, path = judged.scene, judged.path
    status = CANNOT if path.status is Status.REFUSED else str(path.status)
    return replace(
        without_run(scene, engine.name, settings, status, path.message, engine),
        method=path.method or settings.method or "",
        t_end=float(path.times[-1]) if len(path.times) else 0.0,
        steps=int(path.steps),
        rhs_calls=int(path.rhs_calls),
        final=final_state(scene, path),
        estimate=None if path.estimate is None else path.estimate.to_dict(),
        times={key: float(getattr(path.timing, key)) for key in ("build_s", "first_call_s", "loop_s")},
        **measure(judged),
    )


def final_state(scene: Scene, path: Trajectory) -> dict[str, dict[str, Any]]:
    """Return the last sample by body: m, rad, m/s, rad/s; a particle has no angle."""
    if not len(path.times):
        return {}
    ways = {"position": path.position, "velocity": path.velocity}
    turns = {"angle" if path.orientation.ndim == 2 else "orientation": path.orientation}
    whole = ways | turns | {"angular_velocity": path.angular_velocity}
    parts = [ways if body.type == "point_mass" else whole for body in scene.bodies]
    return {
        name: {part: values[-1, k].tolist() for part, values in own.items()}
        for k, (name, own) in enumerate(zip(scene.body_names, parts, strict=True))
    }


def _versions(engine: Engine | None) -> dict[str, str]:
    common = {"python": platform.python_version(), "numpy": np.__version__}
    if engine is None:
        return common
    try:
        return {engine.name: engine.version(), **common}
    except PackageNotFoundError:  # it runs from a source tree that was never installed
        return {engine.name: "not installed", **common}


def without_run(
    scene: Scene, engine_name: str, settings: Settings, status: str, message: str, engine: Engine | None = None
) -> Record:
    """Return the record of a run that has no result, with the sentence why."""
    return Record(
        scene=scene.name, parameters=dict(scene.parameters), engine=engine_name, method=settings.method or "",
        settings=settings.model_dump(mode="json", exclude_none=True), status=status, message=message,
        versions=_versions(engine),
    )  # fmt: skip
