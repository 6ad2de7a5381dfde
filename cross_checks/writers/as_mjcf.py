"""A scene as MJCF with all digits, which MuJoCo's own writer rounds to six, or as a script that runs in MuJoCo alone.

It is taken from the model that the adapter has compiled: moments of inertia along their principal axes, and the start
in a keyframe. Before it is given away it is compiled again and compared, number by number.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from markupsafe import escape

from cross_checks.linkage.links import linkage_of
from cross_checks.writers import Form, Job, NotWritable, job_of, script, turns_of, xml
from mbs_ref import Scene, Settings

DISABLED, ENABLED = {16: "contact", 512: "warmstart"}, {32: "diagexact"}  # bits of flags in the words of MJCF
SAME = 1e-13  # of an array's largest number: MuJoCo normalises quaternions and axes again


def write_mujoco(scene: Scene, settings: Settings) -> str:
    """Return the script: the model as MJCF with all its digits, and the loop in C."""
    job, start = job_of(scene, settings, "mujoco"), linkage_of(scene).theta.tolist()
    return script(job, "mujoco and numpy", model=mjcf_of(job), turns=turns_of(scene), start=start)


def mjcf_of(job: Job) -> str:
    """Return the adapter's model as MJCF, with the options of the run; its keyframe `start` is the state at t = 0."""
    model = job.built.model
    off = {word: "disable" for bit, word in DISABLED.items() if model.opt.disableflags & bit}
    flags = off | {word: "enable" for bit, word in ENABLED.items() if model.opt.enableflags & bit}
    named = {"name": _name, "text": _text, "title": job.scene.name}
    text = xml("model.xml.j2", m=model, start=job.built.data, flags=flags, **named)
    if different := sorted(_differences(model, type(model).from_xml_string(text))):
        raise NotWritable(f"{job.scene.name} as MJCF reads back with other {', '.join(different)}")
    return text


def _differences(one: Any, other: Any) -> Iterator[str]:
    """Yield the arrays and options of a model that are not the same in another."""
    for of, pair in (("", (one, other)), ("opt.", (one.opt, other.opt))):
        for name in dir(pair[0]):
            a, b = (getattr(of_model, name) for of_model in pair)
            if isinstance(a, np.ndarray | float | int) and not name.startswith(("_", "names", "name_", "key_", "nkey")):
                a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
                if name in SIZES:
                    continue
                if a.shape != b.shape or np.any(np.abs(a - b) > SAME * np.max(np.abs(a), initial=1.0)):
                    yield of + name


SIZES = ("nbuffer", "nnames", "nnames_map", "narena", "signature", "npaths")  # of memory, names and the keyframe


def _name(part: Any) -> str:
    """Return a part's name as names of scenes are, so that the file reads back."""
    return escape(part.name.replace("/", "."))


def _text(numbers: Any) -> str:
    """Return numbers with all their digits."""
    return " ".join(repr(float(x)) if isinstance(x, float) else str(int(x)) for x in np.atleast_1d(numbers).tolist())


FORMS = (
    Form("mjcf", ".xml", "a model file of MuJoCo", lambda scene, settings: mjcf_of(job_of(scene, settings, "mujoco"))),
    Form("mujoco", ".py", "a script that runs in MuJoCo alone", write_mujoco),
)
