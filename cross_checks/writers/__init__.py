"""Scenes in the forms of the field: robot files, and scripts that run in one engine alone.

Each file as_*.py states its forms; this folder is listed. What is written is taken from the
model that the engine's adapter has built, so that no writer can drift from its adapter.
"""

import enum
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from cross_checks import engines
from cross_checks.engine import Engine, Plan, plan_run
from cross_checks.linkage.links import linkage_of
from mbs_ref import Scene, Settings
from mbs_ref.trajectory import Trajectory

SCRIPT = ".py"  # the suffix of forms that run


class NotWritable(ValueError):
    """A scene cannot be written in a form; the sentence names each element that stands in the way."""


@dataclass(frozen=True)
class Form:
    """One form that scenes are written in."""

    name: str
    suffix: str  # of the files
    about: str
    write: Callable[[Scene, Settings], str]


@dataclass(frozen=True)
class Job:
    """A scene, an engine, and what its adapter makes of the settings and the scene."""

    scene: Scene
    engine: Engine
    plan: Plan
    built: Any  # the adapter's own model, from which the written one is taken

    @property
    def title(self) -> str:
        """Return one sentence of what runs how."""
        plan = self.plan
        how = f"a step of {float(plan.step)!r} s" if plan.counts else f"rtol = {plan.rtol!r}, atol = {plan.atol!r}"
        return f"{self.scene.name} in {self.engine.name} {self.engine.version()}: {plan.method.name} with {how}."


def job_of(scene: Scene, settings: Settings, engine: str) -> Job:
    """Return what the engine's adapter would run.

    Raises EngineMissing, NotWritable with the adapter's own refusals or where our code computes forces for the engine,
    or ValueError for settings that it does not take.
    """
    adapter = engines.get(engine)
    plan = plan_run(adapter, scene, settings, None)
    if isinstance(plan, Trajectory):
        raise NotWritable(f"{scene.name} is not run by {engine}: {plan.message}")
    job = Job(scene, adapter, plan, adapter.build(scene, plan))
    if getattr(job.built, "applied", None) is not None:
        refuse_shared(job)
    return job


def refuse(scene: Scene, form: str, reasons: Iterable[str]) -> None:
    """Raise NotWritable where there is a reason."""
    if named := list(reasons):
        raise NotWritable(f"{scene.name} cannot be written as {form}: {'; '.join(named)}")


def refuse_shared(job: Job) -> None:
    """Refuse loads and contacts whose forces our code computes for the engine; each is named."""
    parts = [f"{kind} {p.name!r} ({p.type})" for kind in ("load", "contact") for p in getattr(job.scene, f"{kind}s")]
    sentence = f"mbs-ref computes the forces of these, and {job.engine.name} alone cannot: {', '.join(parts)}"
    refuse(job.scene, job.engine.name, [sentence])


def literal(value: Any) -> str:
    """Return Python text of plain data, arrays as lists; floats have all their digits."""
    if isinstance(value, np.ndarray):
        return literal(value.tolist())
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(k)}: {literal(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(literal, value)) + "]"
    if isinstance(value, tuple):
        return "(" + ", ".join(map(literal, value)) + ("," if len(value) == 1 else "") + ")"
    if isinstance(value, np.generic):
        return literal(value.item())
    if value is not None and (isinstance(value, enum.Enum) or not isinstance(value, bool | int | float | str)):
        raise TypeError(f"{value!r} is no plain data")
    return repr(value)


def rows(values: Any) -> str:
    """Return Python text of a list, one entry a line."""
    lines = "".join(f"    {literal(value)},\n" for value in values)
    return f"[\n{lines}]" if lines else "[]"


def times_text(times: np.ndarray) -> str:
    """Return NumPy text of the output times, to the last bit."""
    end, count = float(times[-1]), len(times)
    if np.array_equal(np.linspace(0.0, end, count), times):
        return f"np.linspace(0.0, {end!r}, {count})"
    return f"np.array({literal(times)})"


def counts_text(counts: tuple[int, ...]) -> str:
    """Return Python text of the numbers of steps between outputs."""
    if len(set(counts)) == 1:
        return f"[{counts[0]}] * {len(counts)}"
    return literal(list(counts))


TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parent / "templates"),
    undefined=StrictUndefined, keep_trailing_newline=True, trim_blocks=True, lstrip_blocks=True,
)  # fmt: skip


def xml(template: str, **values: Any) -> str:
    """Return a template as XML with a line for each element, without elements that are empty at its top."""
    text = TEMPLATES.get_template(template).render(values)
    root = ElementTree.fromstring(text, ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True)))
    for empty in [part for part in root if not len(part) and not part.attrib and not (part.text or "").strip()]:
        root.remove(empty)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def script(job: Job, needs: str, **tables: Any) -> str:
    """Return the script of the engine's template; `needs` names the packages it runs with."""
    scene, plan = job.scene, job.plan
    return TEMPLATES.get_template(f"{job.engine.name}.py.j2").render(
        job=job, plan=plan, needs=needs, planar=scene.planar, columns=list(scene.world.columns),
        bodies=scene.body_names, times=times_text(plan.times), literal=literal, rows=rows,
        counts=counts_text(plan.counts) if plan.counts else "", **tables,
    )  # fmt: skip


def turns_of(scene: Scene) -> list[tuple[float, list[int]]] | None:
    """Return each planar body's angle at t = 0 (rad), and the linkage's coordinates that turn it; None in space."""
    if scene.dimension == 3:
        return None
    linkage = linkage_of(scene)
    each = zip(linkage.angle, linkage.turns, strict=True)
    return [(float(angle), np.flatnonzero(row).tolist()) for angle, row in each]


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
