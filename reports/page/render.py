"""Data to HTML: small pages beside one another that load nothing from anywhere else, and compute nothing."""

import base64
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from itertools import groupby
from pathlib import Path

from jinja2 import Environment, FileSystemBytecodeCache, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from cross_checks.records import numbers
from cross_checks.records.plots import style_of
from mbs_ref.kernels.jit import cache_folder
from reports import studies
from reports.facts.report_data import GROWING, ReportData, Section
from reports.page import advice, findings
from reports.page.sections import extremes, matrix, method, overview, plots, prices, profiles
from reports.page.slug import command, engine_file, scene_file, slug
from reports.studies.study import every

TEX = {**{sign: f"\\{sign}" for sign in "&%$#_{}"}, **{sign: f"\\symbol{{{ord(sign)}}}" for sign in "\\~^<>|"}}
TEMPLATES = Path(__file__).parent / "templates"
STUDIES = Path(studies.__file__).parent
SHARED = ("style.css", "pick.js", "page.js")


@dataclass
class Images:
    """The pictures that pages show, each a file of its own unless they are `inside` the page."""

    inside: bool = False
    files: dict[str, bytes] = field(default_factory=dict)

    def add(self, name: str, content: str) -> str:
        """Store a picture given in base64; return the page's address of it."""
        if self.inside:
            return f"data:image/{name.rpartition('.')[2]};base64,{content}"
        self.files[name] = base64.b64decode(content)
        return name


@cache
def templates() -> Environment:
    """Return the templates, whose compiled form is stored beside the kernels' where that folder can be written."""
    loader, pages = FileSystemLoader((TEMPLATES, STUDIES)), select_autoescape(("html",), default_for_string=False)
    templates = Environment(loader=loader, autoescape=pages, undefined=StrictUndefined)
    templates.filters |= {"plain": plain, "tex": tex}
    templates.globals |= {"style_of": style_of, "slug": slug, "repeat": command, "numbers": numbers}
    folder = cache_folder().parent / "templates"
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        templates.bytecode_cache = FileSystemBytecodeCache(str(folder))
    return templates


def plain(text: object) -> str:
    """Return text from records that Markdown does not take for markup."""
    return str(text).replace("&", "&amp;").replace("<", "&lt;").replace("|", "\\|").replace("\n", " ")


def tex(text: object) -> str:
    """Return text from records that LaTeX does not take for markup."""
    return str(text).translate(str.maketrans(TEX)).replace("\n", " ")


def render(data: ReportData) -> dict[str, bytes]:
    """Return every file of the report by its name. Text from the data is escaped; only the report's own scripts run."""
    images, listed = Images(), pages(data)
    built = {page.file: _page(page, listed, data, images).encode() for page in listed}
    shared = {name: (TEMPLATES / name).read_bytes() for name in SHARED}
    return built | shared | {"plotly.js": get_plotlyjs().encode()} | images.files


ALL = "all"  # the fragment that shows every page of a single file


def single(data: ReportData) -> bytes:
    """Return the report as one file that needs no other."""
    images, listed = Images(inside=True), pages(data)
    whole = {page.file: _page(page, listed, data, images) for page in listed}
    bodies = {file: Markup(text[text.index("<body>") + 6 : text.index("</body>")]) for file, text in whole.items()}
    inlined = {name.replace(".", "_"): Markup((TEMPLATES / name).read_text(encoding="utf-8")) for name in SHARED}
    context = {"bodies": bodies, "all": ALL, "plotly": Markup(get_plotlyjs()), **inlined}
    return templates().get_template("single.html").render(context).encode()


def _page(page: "Page", listed: "list[Page]", data: ReportData, images: Images) -> str:
    def body(section: Section) -> Markup:
        shared = {"scenes": page.data.scenes, "absence": data.absence, "page_title": page.title}
        context = {"section": section, "image": images.add, **shared, **section.context(page.data)}
        return Markup(templates().get_template(section.template or f"{section.name}.html").render(context))

    context = {"bodies": [body(section) for section in page.sections], "stamp": data.environment.get("made", "")}
    whole = templates().get_template("page.html")
    return whole.render(page=page, listed=listed, quick=data.quick, incomplete=data.incomplete,
                        growing=data.state == GROWING, **context)  # fmt: skip


INDEX = "index.html"
WRONG, ALL_SCENES, METHOD, CAN = "findings.html", "profiles.html", "method.html", "capabilities.html"


@dataclass(frozen=True)
class Page:
    """A file of the report. `data` is what concerns it."""

    file: str
    title: str
    data: ReportData
    sections: tuple[Section, ...]
    kind: str  # index | scene | engine | study | more: where its link stands


def pages(data: ReportData) -> list[Page]:
    """Return every page, the first screen first."""
    return [
        Page(INDEX, "mbs-ref report", data, (overview.SECTION, overview.FRONTIER, findings.WORST), "index"),
        *(Page(scene_file(name), name, data.only(scenes=[name]), SCENE, "scene") for name in data.scenes),
        *(Page(engine_file(name), name, data.only(engines=[name]), ENGINE, "engine") for name in data.installed),
        Page("extremes.html", "Extremes", data, (extremes.SECTION,), "study"),
        *(
            Page(*of, data, tuple(study.section for study in own), "study")
            for of, own in groupby(every().values(), lambda study: (study.page, study.title))
        ),
        Page(WRONG, "What went wrong", data, (findings.SECTION,), "more"),
        Page(ALL_SCENES, "All scenes at once", data, (profiles.SECTION,), "more"),
        Page(CAN, "What each engine can model", data, (matrix.CAPABILITIES,), "more"),
        Page(METHOD, "How it is judged and timed", data, (method.SECTION, method.TRUTHS, method.ENVIRONMENT), "more"),
    ]


MECHANISM = Section("mechanism", "The mechanism", lambda data: {"mechanisms": data.mechanisms})
RECORDS = Section(
    "records", "Records and commands",
    lambda data: {"groups": {scene: runs for scene in data.scenes if (runs := data.of_scene(scene))}},
)  # fmt: skip
SCENE = (MECHANISM, prices.SECTION, matrix.SECTION, *plots.SECTIONS, method.TRUTHS, RECORDS)
ENGINE = (advice.SECTION, matrix.SECTION, extremes.SECTION, matrix.CAPABILITIES)
