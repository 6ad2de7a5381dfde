"""mbs-ref's language of scenes and its own solver. What is meant for use from a program is listed here.

    import mbs_ref
    scene = mbs_ref.scenes.make("pendulum")

Names are looked up when they are first used, so that importing the package takes no time.
"""

from mbs_ref.public_names import lazily

PUBLIC = {
    "Scene": "mbs_ref.scene",
    "Settings": "mbs_ref.settings",
    "Trajectory": "mbs_ref.trajectory",
    "read_scene": "mbs_ref.scene.toml",
    "write_scene": "mbs_ref.scene.toml",
}
ROOMS = ("scene", "scenes")  # folders that are themselves for use

__getattr__, __dir__ = lazily(__name__, PUBLIC, ROOMS)
