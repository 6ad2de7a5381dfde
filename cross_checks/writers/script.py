"""Scripts in Python from templates, and numbers as source text."""

import enum
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template

from cross_checks.linkage.links import linkage_of
from cross_checks.writers.form import Job
from mbs_ref.scene import Scene
from mbs_ref.trajectory import COLUMNS


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


@cache
def _templates() -> Environment:
    return Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        undefined=StrictUndefined, keep_trailing_newline=True, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip


def template(name: str) -> Template:
    """Return the text that an engine's script is made from, or a part of it."""
    return _templates().get_template(name)


def indented(text: str) -> str:
    """Return XML with a line for each element, without elements that are empty at its top."""
    root = ElementTree.fromstring(text, ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True)))
    for empty in [part for part in root if not len(part) and not part.attrib and not (part.text or "").strip()]:
        root.remove(empty)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def script(job: Job, needs: str, **tables: Any) -> str:
    """Return the script of the engine's template; `needs` names the packages it runs with."""
    scene, plan = job.scene, job.plan
    return (
        template(f"{job.engine.name}.py.j2")
        .render(
            job=job, plan=plan, needs=needs, planar=is_planar(scene), columns=list(COLUMNS[scene.dimension]),
            bodies=scene.body_names, times=times_text(plan.times),
            counts=counts_text(plan.counts) if plan.counts else "",
            literal=literal, rows=rows, **tables,
        )
    )  # fmt: skip


def is_planar(scene: Scene) -> bool:
    return scene.dimension == 2


def turns_of(scene: Scene) -> list[tuple[float, list[int]]] | None:
    """Return each planar body's angle at t = 0 (rad), and the linkage's coordinates that turn it; None in space."""
    if not is_planar(scene):
        return None
    linkage = linkage_of(scene)
    each = zip(linkage.angle, linkage.turns, strict=True)
    return [(float(angle), np.flatnonzero(row).tolist()) for angle, row in each]
