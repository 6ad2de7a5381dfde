"""Scenes in the forms of the field: robot files, and scripts that run in one engine alone.

Each file here but `form.py` and what scripts share is one form, found by listing. What is written is taken from the
model that the engine's adapter has built, so that no writer can drift from its adapter.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path

from cross_checks.engines.writers.form import Form, Job, NotWritable
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

__all__ = ["Form", "Job", "NotWritable", "forms", "write"]


@cache
def forms() -> dict[str, Form]:
    """Return the forms by name."""
    files = sorted(path.stem for path in Path(__file__).parent.glob("as_*.py"))
    found = [import_module(f"{__name__}.{stem}").FORM for stem in files]
    return {form.name: form for form in found}


def write(scene: Scene, form: str, settings: Settings | None = None) -> str:
    """Return the scene as text; `settings` say how a script runs it.

    Raises ValueError for an unknown form, NotWritable naming each element that has no place in the form, EngineMissing
    where the engine whose model is written is not installed.
    """
    known = forms()
    if form not in known:
        raise ValueError(f"form = {form!r} is unknown; allowed: {', '.join(known)}")
    return known[form].write(scene, settings or Settings())
