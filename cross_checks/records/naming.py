"""What a run is called: its physics, engine, adapter, method, settings, and the code that makes it."""

import hashlib
import importlib
import json
import pkgutil
from functools import cache
from typing import Any

import numpy as np

from cross_checks import truths
from cross_checks.engine import Engine
from cross_checks.truths import of
from cross_checks.truths.stored_poses import file_of, physics_of
from mbs_ref import Scene, Settings
from mbs_ref.kernels.jit import source_digest, sources_of

MEASURING = "cross_checks.judge.measure"  # whose changes make records anew
LISTED_BY = {"mbs_ref.integrators": "mbs_ref.integrators.methods", "cross_checks.metrics": "cross_checks.metrics"}
LISTING = frozenset(LISTED_BY)  # packages that import what lies in a folder by listing it


def run_name(scene: Scene, engine: Engine, settings: Settings, times: np.ndarray) -> str:
    """Return the key of a run; the same wherever and whenever it is made, and whatever the scene is called."""
    facts = {
        "physics": physics_of(scene),
        "times": hashlib.sha256(np.ascontiguousarray(times, dtype=float).tobytes()).hexdigest(),
        "engine": engine_key(engine),
        "settings": settings.model_dump(mode="json", exclude_none=True),
        "measured by": code_of(MEASURING),
    }
    return digest_of(facts)


def engine_key(engine: Engine) -> list[str]:
    """Return what a result of an engine depends on: its name, version, adapter and the contract's code."""
    codes = [code_of(type(engine).__module__), code_of(Engine.__module__), engine.made_of]
    return [engine.name, engine.version(), *filter(None, codes)]


def truth_name(scene: Scene, times: np.ndarray) -> str:
    """Return the key of a truth: the scene's physics, the times, the code of the truths, and its stored poses."""
    code = [source_digest(name) for name in sorted(_modules_in(of.__name__))]
    file = file_of(scene)
    poses = hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else ""
    known = [physics_of(scene), poses, np.asarray(times, dtype=float).tolist()]
    return digest_of([*known, code, source_digest(truths.__name__)])


def digest_of(facts: Any) -> str:
    """Return a digest of plain data."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


@cache
def code_of(module: str) -> str:
    """Return a digest of an adapter, of the modules of its own folder, and of all that they import of this project."""
    made = importlib.import_module(module)
    inner = [info.name for info in pkgutil.iter_modules(getattr(made, "__path__", []), f"{module}.")]
    listed = [name for folder in sources_of(module) & LISTING for name in _modules_in(LISTED_BY[folder])]
    return digest_of([source_digest(name) for name in sorted({module, *inner, *listed})])


def _modules_in(package: str) -> list[str]:
    return [info.name for info in pkgutil.iter_modules(importlib.import_module(package).__path__, f"{package}.")]
