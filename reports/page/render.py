"""Data to HTML: small pages beside one another that load nothing from anywhere else, and compute nothing."""

from __future__ import annotations

import base64
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemBytecodeCache, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from mbs_ref.kernels.jit import cache_folder
from reports import studies
from reports.drawing.plots.palette import style_of
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.page.pages import Page, pages
from reports.page.slug import slug

TEMPLATES = Path(__file__).parent / "templates"
STUDIES = Path(studies.__file__).parent
SHARED = ("style.css", "pick.js", "page.js")


@dataclass
class Images:
    """The pictures that pages show, each a file of its own."""

    files: dict[str, bytes] = field(default_factory=dict)

    def add(self, name: str, content: str) -> str:
        """Keep a picture given in base64; return its name."""
        self.files[name] = base64.b64decode(content)
        return name


@cache
def templates() -> Environment:
    """Return the templates, whose compiled form is kept beside the kernels' where that folder can be written."""
    templates = Environment(loader=FileSystemLoader((TEMPLATES, STUDIES)), autoescape=True, undefined=StrictUndefined)
    templates.globals |= {"style_of": style_of, "slug": slug}
    folder = cache_folder().parent / "templates"
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        templates.bytecode_cache = FileSystemBytecodeCache(str(folder))
    return templates


def render(data: ReportData) -> dict[str, bytes]:
    """Return every file of the report by its name. Text from the data is escaped; only the report's own scripts run."""
    images, listed = Images(), pages(data)
    made = {page.file: _page(page, listed, data, images).encode() for page in listed}
    shared = {name: (TEMPLATES / name).read_bytes() for name in SHARED}
    return made | shared | {"plotly.js": get_plotlyjs().encode()} | images.files


def _page(page: Page, listed: list[Page], data: ReportData, images: Images) -> str:
    def body(section: Section) -> Markup:
        shared = {"scenes": page.data.scenes, "absence": data.absence}
        context = {"section": section, "image": images.add, **shared, **section.context(page.data)}
        return Markup(templates().get_template(section.template or f"{section.name}.html").render(context))

    return (
        templates()
        .get_template("page.html")
        .render(
            page=page,
            listed=listed,
            bodies=[body(section) for section in page.sections],
            quick=data.quick,
            incomplete=data.incomplete,
            stamp=data.environment.get("made", ""),
        )
    )
