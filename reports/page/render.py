"""Data to HTML: one file that loads nothing from anywhere."""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from itertools import takewhile
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from reports.page.contents import SECTIONS
from reports.page.plots.palette import colours
from reports.page.report_data import ReportData
from reports.page.section import Section

TEMPLATES = Path(__file__).parent / "templates"
STUDIES = Path(__file__).parents[1] / "studies"
SCRIPTS = ("pick.js", "page.js")


@cache
def _templates() -> Environment:
    return Environment(loader=FileSystemLoader((TEMPLATES, STUDIES)), autoescape=True, undefined=StrictUndefined)


def render(data: ReportData) -> str:
    """Return the whole page. Text from the data is escaped; only this project's own scripts may run."""
    engine_colours = colours(data.engines)
    plotly, js = get_plotlyjs(), "".join((TEMPLATES / name).read_text(encoding="utf-8") for name in SCRIPTS)

    opening = list(takewhile(lambda section: not section.plots, SECTIONS))

    def body(section: Section) -> Markup:
        shared = {"scenes": data.scenes, "engine_colours": engine_colours, "absence": data.absence}
        context = {"section": section, **shared, **section.context(data)}
        return Markup(_templates().get_template(section.template or f"{section.name}.html").render(context))

    return (
        _templates()
        .get_template("page.html")
        .render(
            sections=SECTIONS,
            opening=opening,
            closing=[section for section in SECTIONS[len(opening) :] if not section.plots],
            body=body,
            scenes=data.scenes,
            engines=engine_colours,
            quick=data.quick,
            incomplete=data.incomplete,
            stamp=data.environment.get("made", ""),
            css=Markup((TEMPLATES / "style.css").read_text(encoding="utf-8")),
            plotly=Markup(plotly),
            js=Markup(js),
            script_hashes=Markup(" ".join(_script_hash(script) for script in (plotly, js))),
        )
    )


def _script_hash(script: str) -> str:
    """Return the content-security-policy source that lets exactly this inline script run."""
    # the HTML parser turns CR LF into LF before it hashes
    digest = hashlib.sha256(script.replace("\r\n", "\n").encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
