"""mbs-ref's language of scenes and its own solver. What is meant for use from a program is listed here.

    import mbs_ref
    scene = mbs_ref.scenes.make("pendulum")

Names are looked up when they are first used, so that importing the package takes no time.
"""

import importlib

PUBLIC = {
    "Scene": "mbs_ref.scene",
    "Settings": "mbs_ref.settings",
    "Trajectory": "mbs_ref.trajectory",
    "read_scene": "mbs_ref.scene.toml",
    "write_scene": "mbs_ref.scene.toml",
}
ROOMS = ("scene", "scenes")  # folders that are themselves for use


def __getattr__(name: str) -> object:
    if name in ROOMS:
        return importlib.import_module(f"mbs_ref.{name}")
    if name not in PUBLIC:
        raise AttributeError(f"mbs_ref has no {name!r}; public are {', '.join(sorted((*PUBLIC, *ROOMS)))}")
    return getattr(importlib.import_module(PUBLIC[name]), name)


def __dir__() -> list[str]:
    return sorted((*PUBLIC, *ROOMS))
