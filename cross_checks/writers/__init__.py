"""Scenes in the forms of the field: robot files, and scripts that run in one engine alone.

Each file as_*.py states its forms; this folder is listed. What is written is taken from the
model that the engine's adapter has built, so that no writer can drift from its adapter.
"""

import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

from cross_checks.writers.script import Form, Job, NotWritable
from mbs_ref import Scene, Settings

__all__ = ["Form", "Job", "NotWritable", "forms", "write"]
SCRIPT = ".py"  # the suffix of forms that run


@cache
def forms() -> dict[str, Form]:
    """Return the forms by name."""
    files = sorted(path.stem for path in Path(__file__).parent.glob("as_*.py"))
    return {form.name: form for stem in files for form in import_module(f"{__name__}.{stem}").FORMS}


def write(scene: Scene, form: str, settings: Settings | None = None) -> str:
    """Return the scene as text; `settings` state how a script runs it. A script is run once to its end.

    Raises ValueError for an unknown form, NotWritable for a script that stops or naming each element that the form
    cannot represent, EngineMissing where the engine whose model is written is not installed.
    """
    known = forms()
    if form not in known:
        raise ValueError(f"form = {form!r} is unknown; allowed: {', '.join(known)}")
    text = known[form].write(scene, settings or Settings())
    if known[form].suffix == SCRIPT:
        with TemporaryDirectory() as folder:
            file = Path(folder) / "script.py"
            file.write_text(text)
            done = subprocess.run([sys.executable, file], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            raise NotWritable(f"{scene.name} cannot be written as {form}: its script stops: {lines[-1]}")
    return text
