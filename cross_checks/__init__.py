"""Engines behind one contract, truths, and what is said of runs. What is meant for use from a program is listed here.

    import cross_checks
    run = cross_checks.run(scene, "mujoco", step=1e-3)

Names are looked up when they are first used, so that importing the package takes no time.
"""

import importlib

PUBLIC = {
    "Engine": "cross_checks.engine",
    "check": "cross_checks.judge.library",
    "frame": "cross_checks.records.frames",
    "run": "cross_checks.judge.library",
    "samples": "cross_checks.records.frames",
    "write": "cross_checks.engines.writers",
}
ROOMS = ("engines",)  # folders that are themselves for use


def __getattr__(name: str) -> object:
    if name in ROOMS:
        return importlib.import_module(f"cross_checks.{name}")
    if name not in PUBLIC:
        raise AttributeError(f"cross_checks has no {name!r}; public are {', '.join(sorted((*PUBLIC, *ROOMS)))}")
    return getattr(importlib.import_module(PUBLIC[name]), name)


def __dir__() -> list[str]:
    return sorted((*PUBLIC, *ROOMS))
