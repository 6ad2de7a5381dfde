"""A script that runs in MuJoCo alone."""

from cross_checks.linkage.links import linkage_of
from cross_checks.writers.as_mjcf import mjcf_of, mujoco_job
from cross_checks.writers.form import Form
from cross_checks.writers.script import script, turns_of
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings


def write_mujoco(scene: Scene, settings: Settings) -> str:
    """Return the script: the model as MJCF with all its digits, and the loop in C."""
    job = mujoco_job(scene, settings)
    turns = turns_of(scene)
    start = linkage_of(scene).theta.tolist()
    return script(job, "mujoco and numpy", model=mjcf_of(job), turns=turns, start=start)


FORM = Form("mujoco", ".py", "a script that runs in MuJoCo alone", write_mujoco)
