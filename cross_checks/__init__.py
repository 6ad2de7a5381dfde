"""Engines behind one contract, truths, and what is said of runs. What is meant for use from a program is listed here.

    import cross_checks
    run = cross_checks.run(scene, "mujoco", step=1e-3)

Names are looked up when they are first used, so that importing the package takes no time.
"""

from mbs_ref.public_names import lazily

PUBLIC = {
    "Engine": "cross_checks.engine",
    "check": "cross_checks.judge.library",
    "frame": "cross_checks.records.frames",
    "run": "cross_checks.judge.library",
    "samples": "cross_checks.records.frames",
    "write": "cross_checks.engines.writers",
}
ROOMS = ("engines",)  # folders that are themselves for use

__getattr__, __dir__ = lazily(__name__, PUBLIC, ROOMS)
