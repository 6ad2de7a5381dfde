"""python -m reports.site.links FOLDER: every link and picture of the built pages leads to something that is there.

Nothing is fetched: what leads outside is counted, and has to be a well-formed address.
"""

import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

POINTING = {"a": "href", "link": "href"} | dict.fromkeys(("img", "script", "source", "iframe", "video"), "src")
OUTSIDE = ("http", "https", "mailto")
NOTHING = ("data", "javascript")  # what needs no file


class Page(NamedTuple):
    """What a page points to, and what may be pointed to in it."""

    links: tuple[str, ...]
    anchors: frozenset[str]


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.anchors |= {value for key in ("id", "name") if (value := given.get(key))}
        target = given.get(POINTING.get(tag, ""))
        if target is not None:
            self.links.append(target)


def read(file: Path) -> Page:
    """Return the links and anchors of a page."""
    reader = _Reader()
    reader.feed(file.read_text(encoding="utf-8"))
    return Page(tuple(reader.links), frozenset(reader.anchors))


def broken(folder: Path) -> Iterator[str]:
    """Yield a sentence for every link of a page that leads nowhere."""
    root = folder.resolve()
    pages = {file.resolve(): read(file) for file in sorted(root.rglob("*.html"))}
    for file, page in pages.items():
        for link in dict.fromkeys(page.links):
            if why := _trouble(root, pages, file, link):
                yield f"{file.relative_to(root)}: {link!r} {why}"


def _trouble(root: Path, pages: dict[Path, Page], file: Path, link: str) -> str:
    parts = urlsplit(link)
    if parts.scheme in OUTSIDE:
        return "" if parts.netloc or parts.path else "names no host"
    if parts.scheme in NOTHING:
        return ""
    if parts.scheme or parts.netloc:
        return f"has the scheme {parts.scheme!r}, which no page needs"
    path = unquote(parts.path)
    base = root if path.startswith("/") else file.parent
    target = (base / path.lstrip("/")).resolve() if path else file
    if target.is_dir():
        target = target / "index.html"
    if not target.is_file():
        return "leads to no file"
    anchor = unquote(parts.fragment)
    if anchor and target in pages and anchor not in pages[target].anchors:
        return f"leads to no place {anchor!r} there"
    return ""


def main(folder: Path) -> int:
    """Print what is broken; return the exit code."""
    result = list(broken(folder))
    for sentence in result:
        print(sentence, file=sys.stderr)
    pages = len(list(folder.rglob("*.html")))
    print(f"{pages} pages, {len(result)} broken links", file=sys.stderr)
    return 1 if result or not pages else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m reports.site.links FOLDER")
    sys.exit(main(Path(sys.argv[1])))
