"""Truths and proofs: whether a truth lies in its enclosure, and enclosures as truths."""

import gzip
import hashlib
import json
import random
import time
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks.truths import EPS, seek_truth, stored_poses
from cross_checks.truths.proofs.checker.formulas import Refused
from cross_checks.truths.proofs.checker.proof import check
from cross_checks.truths.proofs.derivation import NotCovered
from cross_checks.truths.proofs.integrate import prove
from cross_checks.truths.truth import NoTruth, Truth, unturned
from mbs_ref import Scene, scenes
from mbs_ref.files import write_atomic
from mbs_ref.observables.distance import farthest
from mbs_ref.scene.euler_parameters import product

SUFFIX = ".log.gz"
Enclosures = list[list[list[Any]]]  # at every time and of every body: balls of place, turn, velocity and spin


def examine(
    scene: Scene, times: np.ndarray, aim: float, limit: float, folder: Path
) -> tuple[dict[str, Any], Truth | None]:
    """Prove a scene at `times` (s), check the log as a file holds it, and compare the truth computed afresh.

    Return the figures, and the proof as a truth; None where it does not reach the end, or where the motion is not
    unique. `limit` is the prover's processor time (s). `distance` (m) and `turned` (rad) are of the truth from the
    proof; where it is inside, both uncertainties and the rounding of both angles allow them. `folder` keeps the logs of
    complete proofs by the digest of the scene's physics: a log that is stored is checked again instead.
    """
    row: dict[str, Any] = {"scene": scenes.label(scene.name, scenes.chosen(scene.name, scene.parameters))}
    file = stored_poses.file_of(scene, folder, SUFFIX)
    try:
        log = read_log(file) if file.is_file() else {}
        if (log.get("times"), log.get("inputs")) != (times.tolist(), "binary64") or log["radius"] > aim:
            log = prove(scene, times.tolist(), aim, limit=limit).log
            if not log["reason"]:
                folder.mkdir(parents=True, exist_ok=True)
                write_log(log, file)
        began, data = time.process_time(), json.dumps(log).encode()
        checked = check(json.loads(data))
    except NotCovered as error:
        return row | {"truth": "not proven", "reason": str(error)}, None
    except Refused as error:
        known = f"{file} is refused, remove it to prove the scene again: " if file.is_file() else ""
        return row | {"truth": "refused" if known else "not proven", "reason": f"{known}{error}"}, None
    if stored_poses.physics_of(checked.model.scene) != stored_poses.physics_of(scene):
        return row | {"truth": "refused", "reason": f"{file} proves another scene"}, None
    row |= {
        "t_end": float(times[-1]), "reached": min(checked.reached, float(times[-1])), "radius": checked.radius,
        "steps": len(log["steps"]), "prover_s": log["seconds"], "checker_s": time.process_time() - began,
        "log_bytes": file.stat().st_size if file.is_file() else len(gzip.compress(data)), "reason": log["reason"],
    }  # fmt: skip
    if log["reason"]:
        return row | {"truth": "not proven"}, None
    truth = seek_truth(scene, times, afresh=True)
    proof = as_truth(scene, checked.enclosures, hashlib.sha256(data).hexdigest())
    unique = None if checked.model.is_exhibited else proof
    if isinstance(truth, NoTruth):
        return row | {"truth": "none"}, unique
    (apart, turned, *_), allowed = farthest(scene, proof, truth), truth.uncertainty + proof.uncertainty
    rounding = 2.0 * EPS * np.abs(proof.orientation).max()  # rad, of both; `allowed` has that of both places
    outside = apart > allowed or turned > allowed + rounding  # NaN of particles
    word = "outside" if outside else "inside"
    return row | {"truth": word, "distance": apart, "turned": turned, "uncertainty": allowed}, unique


def as_truth(scene: Scene, enclosures: Enclosures, digest: str = "") -> Truth:
    """Return the middles of enclosures as a truth; its uncertainty adds their rounding to the largest radius."""
    radius = max(float(x.rad()) for at in enclosures for own in at for x in own)
    count, dimension = len(enclosures), scene.dimension
    position, velocity = np.zeros((2, count, len(scene.bodies), dimension))
    orientation = unturned(position)
    spin = np.zeros((count, len(scene.bodies), *np.shape(scene.world.still)))
    bodies: tuple[Any, ...] = scene.bodies
    for j, body in enumerate(bodies):
        own = np.array([[float(x.mid()) for x in at[j]] for at in enclosures])
        position[:, j], velocity[:, j] = own[:, :dimension], own[:, 8 : 8 + dimension]
        if body.type == "planar":
            orientation[:, j], spin[:, j] = own[:, 3] + body.angle, own[:, 13]
        elif body.type == "spatial":
            first = np.array(body.orientation) / np.linalg.norm(body.orientation)
            orientation[:, j], spin[:, j] = product(own[:, 4:8], first), own[:, 11:]
    rounding = EPS * np.abs(np.concatenate([velocity.reshape(count, -1), spin.reshape(count, -1)], 1)).max(1)
    how = f"enclosed by a proof to {radius:.1e} (m, rad, m/s, rad/s), log sha256 {digest[:16]}"
    return Truth(
        position, orientation, radius + EPS * float(np.abs(position).max()), "proven", how, None, False, velocity,
        spin, radius + rounding,
    )  # fmt: skip


def varied(scene: Scene, seed: int) -> Scene:
    """Return a library's scene with its parameters off by at most a tenth; as it is where none such is allowed."""
    dice = random.Random(f"{scene.name} {seed}")
    for _ in range(10):
        changed = {k: x * dice.uniform(0.9, 1.1) if isinstance(x, float) else x for k, x in scene.parameters.items()}
        try:
            return scenes.make(scene.name, **changed)
        except ValueError:
            continue
    return scene


def kept(folder: Path) -> list[tuple[Scene, np.ndarray, float]]:
    """Return the scenes whose logs a folder keeps, with the times (s) and the radius of each log."""
    found = map(read_log, sorted(folder.glob(f"*{SUFFIX}")))
    return [(Scene.model_validate(log["scene"]), np.array(log["times"]), log["radius"]) for log in found]


def write_log(log: dict[str, Any], file: Path) -> int:
    """Write a log; return its bytes."""
    data = gzip.compress(json.dumps(log, separators=(",", ":")).encode(), mtime=0)
    write_atomic(file, data)
    return len(data)


def read_log(file: Path) -> dict[str, Any]:
    """Return the log in a file. Refused where it holds none."""
    try:
        log = json.loads(gzip.decompress(file.read_bytes()))
    except (OSError, EOFError, ValueError) as error:
        raise Refused(f"{file} holds no log: {error}") from error
    if not isinstance(log, dict):
        raise Refused(f"{file} holds no log")
    return log
