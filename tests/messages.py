"""python -m tests.messages [PACKAGE...]: every text that a user can meet, one a line with its place.

Texts are the literal strings inside raised exceptions, printed lines, command-line help and the messages of engines.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PACKAGES = ("mbs_ref", "cross_checks", "benchmarks", "reports")
PRINTED = frozenset({
    "echo", "print", "show_table", "table", "awaited", "progress", "report", "option", "argument", "command", "group",
    "add_row", "Finding", "Section", "Refusal", "NoTruth", "stopped", "say", "ClickException",
})  # fmt: skip
SHOWN = frozenset(
    {"help", "message", "reason", "note", "title", "lead", "sentence"}
)  # keywords, and names of constants
FEWEST = 2  # words of a text: a single one is a name or a unit


class Message(NamedTuple):
    """A text with its place; what is filled in stands as {...}."""

    file: str
    line: int
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"


def messages(*packages: str) -> list[Message]:
    """Return the messages of the packages, of all four unless given, in the order of the files."""
    files = (path for name in packages or PACKAGES for path in sorted((ROOT / name).rglob("*.py")))
    return [message for path in files for message in of_file(path)]


def of_file(path: Path) -> Iterator[Message]:
    """Yield the messages of one file, each once."""
    found: dict[tuple[int, str], None] = {}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        for part in _shown(node):
            found |= dict.fromkeys((text.lineno, _text(text)) for text in _texts(part))
    for line, text in sorted(found):
        if len(text.split()) >= FEWEST:
            yield Message(str(path.relative_to(ROOT)), line, " ".join(text.split()))


def _shown(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the parts of a node that a user reads."""
    if isinstance(node, ast.Raise) and node.exc is not None:
        yield node.exc
    elif isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        yield from [*node.args, *node.keywords] if name in PRINTED else []
        yield from (word for word in node.keywords if word.arg in SHOWN)
    elif isinstance(node, ast.FunctionDef) and any("click" in ast.unparse(one) for one in node.decorator_list):
        yield from node.body[:1]
    elif isinstance(node, ast.Assign) and any(_is_shown(target) for target in node.targets):
        yield node.value


def _is_shown(target: ast.expr) -> bool:
    return isinstance(target, ast.Name) and target.id.lower().rpartition("_")[2] in SHOWN


def _texts(node: ast.AST) -> Iterator[ast.Constant | ast.JoinedStr]:
    """Yield the outermost strings inside a node."""
    if isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str)):
        yield node
    else:
        for child in ast.iter_child_nodes(node):
            yield from _texts(child)


def _text(node: ast.Constant | ast.JoinedStr) -> str:
    if isinstance(node, ast.Constant):
        return str(node.value)
    return "".join(str(part.value) if isinstance(part, ast.Constant) else "{...}" for part in node.values)


if __name__ == "__main__":
    print(*messages(*sys.argv[1:]), sep="\n")
