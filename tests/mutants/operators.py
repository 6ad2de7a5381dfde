"""Defects made by rule from sources: a sign, a factor, a comparison, an index, a bound wrong.

They are drawn once and kept. After sources have changed this keeps those whose text is still there, and draws others
for the rest. Stale defects that were written by hand are printed: their text is to be corrected by hand.

    python -m tests.mutants.operators
"""

from __future__ import annotations

import ast
import functools
import random
from collections.abc import Callable, Iterator
from pathlib import Path

from tests.mutants.defect import FOLDER, ROOT, Defect, read, stale, write

# folder or file -> how many defects are drawn from it
DRAWN = {
    "mbs_ref/kernels/particles": 24, "mbs_ref/kernels/planar": 20, "mbs_ref/kernels/spatial": 26,
    "mbs_ref/kernels/rigid": 20, "mbs_ref/kernels/contact": 6, "mbs_ref/kernels/algebra": 6,
    "mbs_ref/integrators/loop": 14, "mbs_ref/integrators/stages": 8, "mbs_ref/integrators/methods": 10,
    "mbs_ref/crash/injury.py": 12, "mbs_ref/crash/results.py": 8, "mbs_ref/observables": 20,
    "mbs_ref/simulate": 10, "cross_checks/metrics": 10, "cross_checks/judge": 8, "cross_checks/engine": 12,
    "cross_checks/engines": 14, "cross_checks/truths": 30,
    "cross_checks/conformance/symmetry": 6,
}  # fmt: skip
SWAPPED = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
COMPARED = {ast.Lt: ">", ast.Gt: "<", ast.LtE: ">", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "=="}
BOUNDS = {ast.Lt: "<=", ast.Gt: ">=", ast.LtE: "<", ast.GtE: ">", ast.Is: "is not", ast.IsNot: "is"}
CALLED = {"sin": "cos", "cos": "sin", "min": "max", "max": "min", "any": "all", "all": "any", "sum": "max"}


def rewritten(node: ast.AST, source: str) -> Iterator[tuple[str, str]]:
    """Yield wrong texts for a node, with what is wrong."""

    def text(part: ast.AST) -> str:
        return ast.get_source_segment(source, part) or ""

    if isinstance(node, ast.BinOp) and type(node.op) in SWAPPED and not _is_text(node):
        left, right = text(node.left), text(node.right)
        if isinstance(node.right, ast.BinOp):
            right = f"({right})"
        yield f"{left} {SWAPPED[type(node.op)]} {right}", f"{SWAPPED[type(node.op)]} for its opposite"
        if isinstance(node.op, ast.Add | ast.Sub):
            yield text(node.left), "a term dropped"
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARED:
        sign = COMPARED[type(node.ops[0])]
        yield f"{text(node.left)} {sign} {text(node.comparators[0])}", "a comparison turned round"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        yield text(node.operand), "a sign dropped"
    if isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value not in (0.0, 1.0):
        yield repr(node.value * 1.25), "a constant a quarter too large"
    if isinstance(node, ast.Call) and text(node.func).split(".")[-1] in CALLED:
        name = text(node.func)
        wrong = name.removesuffix(name.split(".")[-1]) + CALLED[name.split(".")[-1]]
        yield text(node).replace(name, wrong, 1), f"{wrong} for {name}"
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and node.slice.value in (0, 1):
        yield f"{text(node.value)}[{1 - int(node.slice.value)}]", "the wrong index"
    if isinstance(node, ast.AugAssign) and type(node.op) in SWAPPED:
        yield f"{text(node.target)} {SWAPPED[type(node.op)]}= {text(node.value)}", "added for taken off"
    yield from _more(node, text)
    yield from _beside(node, text, source)


def _more(node: ast.AST, text: Callable[[ast.AST], str]) -> Iterator[tuple[str, str]]:
    """Yield an outsider's mistakes: a class's boundary, a condition, a place, an order, a line."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in BOUNDS:
        yield f"{text(node.left)} {BOUNDS[type(node.ops[0])]} {text(node.comparators[0])}", "the boundary's other side"
    if isinstance(node, ast.BoolOp):
        word = " or " if isinstance(node.op, ast.And) else " and "
        yield word.join(text(part) for part in node.values), f"{word.strip()} for its opposite"
        yield " and ".join(text(part) for part in node.values[:-1]), "a condition dropped"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield text(node.operand), "a negation dropped"
    if isinstance(node, ast.IfExp):
        yield f"({text(node.body)})", "a case dropped"
    if isinstance(node, ast.Constant) and type(node.value) is int and node.value > 0:
        yield str(node.value + 1), "one more"
    if isinstance(node, ast.Constant) and type(node.value) is bool:
        yield str(not node.value), "yes for no"
    if isinstance(node, ast.Subscript) and text(node.slice) in ("0", "-1"):
        yield f"{text(node.value)}[{-1 - int(text(node.slice))}]", "the first for the last"
    if isinstance(node, ast.Call) and len(node.args) > 1 and text(node.args[0]) != text(node.args[1]):
        first, second, *others = [text(arg) for arg in node.args]
        wrong = [second, first, *others, *(text(k) for k in node.keywords)]
        if not any(isinstance(arg, ast.Starred) for arg in node.args[:2]) and text(node.func) not in ("min", "max"):
            yield f"{text(node.func)}({', '.join(wrong)})", "arguments exchanged"
    if isinstance(node, ast.Call) and any(k.arg in ("key", "reverse", "default") for k in node.keywords):
        given = [*(text(a) for a in node.args), *(text(k) for k in node.keywords if k.arg not in ("key", "reverse"))]
        yield f"{text(node.func)}({', '.join(given)})", "another order"
    if isinstance(node, ast.ListComp | ast.GeneratorExp | ast.SetComp | ast.DictComp):
        for condition in node.generators[0].ifs:
            yield text(node).replace(f" if {text(condition)}", "", 1), "a filter dropped"


def _beside(node: ast.AST, text: Callable[[ast.AST], str], source: str) -> Iterator[tuple[str, str]]:
    """Yield the column beside: another attribute, or another key, that the file reads of the same object."""
    attributes, keys = _read(source)
    if isinstance(node, ast.Attribute):
        others = sorted(attributes.get(ast.unparse(node.value), set()) - {node.attr})
        if node.attr in attributes.get(ast.unparse(node.value), ()) and others:
            yield f"{text(node.value)}.{others[len(source) % len(others)]}", "the attribute beside"
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str):
        others = sorted(keys - {node.slice.value})
        if others:
            key = others[node.lineno % len(others)]
            yield f'{text(node.value)}["{key}"]', "the key beside"


@functools.cache
def _read(source: str) -> tuple[dict[str, set[str]], set[str]]:
    """Return the attributes that are read, not called, of each object, and the texts used as keys."""
    tree = ast.parse(source)
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    attributes: dict[str, set[str]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and id(node) not in called and isinstance(node.ctx, ast.Load):
            attributes.setdefault(ast.unparse(node.value), set()).add(node.attr)
    keys = {node.slice.value for node in ast.walk(tree) if isinstance(node, ast.Subscript)
            and isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str)}  # fmt: skip
    return attributes, keys


def _is_text(node: ast.BinOp) -> bool:
    return any(isinstance(x, ast.JoinedStr) or (isinstance(x, ast.Constant) and isinstance(x.value, str))
               for x in ast.walk(node))  # fmt: skip


def defects_of(file: Path) -> Iterator[Defect]:
    """Yield every defect the rules make of a file whose text occurs once in it, on one line, within a function."""
    source = file.read_text()
    for function in ast.walk(ast.parse(source)):
        if not isinstance(function, ast.FunctionDef):
            continue
        for statement in function.body:
            for node in ast.walk(statement):
                if isinstance(node, ast.expr | ast.AugAssign) and node.lineno == node.end_lineno:
                    yield from _anchored(file, source, function.name, node)


def _anchored(file: Path, source: str, function: str, node: ast.AST) -> Iterator[Defect]:
    plain = ast.get_source_segment(source, node) or ""
    line = source.splitlines()[node.lineno - 1]  # type: ignore[attr-defined]
    for wrong, what in rewritten(node, source):
        # a text too short to be unique is given with its line
        start = len(line.encode()[: node.col_offset].decode())  # type: ignore[attr-defined]
        whole = line.strip(), (line[:start] + wrong + line[start + len(plain) :]).strip()
        for old, new in ((plain, wrong), whole):
            if len(old) >= 12 and source.count(old) == 1 and old != new:
                yield Defect(str(file.relative_to(ROOT)), old, new, f"{function}: {what}")
                break


def renewed(kept: list[Defect]) -> list[Defect]:
    """Return the defects whose text is still found, and as many drawn anew as DRAWN says, spread over functions."""
    found = [defect for defect in kept if not stale([defect])]
    for where, count in DRAWN.items():
        own = [defect for defect in found if defect.file.startswith(where)]
        found += _drawn(where, count - len(own), {defect.name for defect in own})
    return found


def _drawn(where: str, count: int, known: set[str]) -> list[Defect]:
    if count <= 0:
        return []
    chance = random.Random(f"{where} {len(known)}")
    files = sorted((ROOT / where).rglob("*.py")) if (ROOT / where).is_dir() else [ROOT / where]
    each = {d.name: d for file in files for d in defects_of(file) if d.name not in known}.values()
    groups: dict[tuple[str, str], list[Defect]] = {}
    for defect in each:
        groups.setdefault((defect.file, defect.breaks.split(":")[0]), []).append(defect)
    heads = list(groups.values())
    chance.shuffle(heads)
    rounds = [chance.choice(group) for group in heads for _ in range(1 + count // len(heads))]
    chance.shuffle(rounds)
    return list({d.name: d for d in rounds}.values())[:count]


if __name__ == "__main__":
    by_hand = read(FOLDER / "by_hand.jsonl")
    written = {defect.name for defect in by_hand}
    drawn = renewed(read(FOLDER / "by_operator.jsonl"))
    write((defect for defect in drawn if defect.name not in written), FOLDER / "by_operator.jsonl")
    print(*stale(by_hand), sep="\n")
