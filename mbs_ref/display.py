"""Tables of objects for notebooks: short, escaped HTML without colours of its own."""

import html
from collections.abc import Iterable, Sequence
from typing import Any

MOST_ROWS = 12
LEFT = ' style="text-align:left"'


def facts(title: str, rows: Iterable[tuple[str, Any]]) -> str:
    """Return a table of names and values; an empty value leaves its row out."""
    filled = [(name, value) for name, value in rows if value not in (None, "", ())]
    return listing(title, (), filled, most=len(filled))


def listing(title: str, head: Sequence[str], rows: Sequence[Sequence[Any]], most: int = MOST_ROWS) -> str:
    """Return an HTML table with a head; of more than `most` rows the rest is given as a number."""
    shown = [_row(row, "td") for row in rows[:most]]
    rest = f"<tr><td colspan=9>and {len(rows) - most} more</td></tr>" if len(rows) > most else ""
    return (
        f"<table><caption{LEFT}><b>{html.escape(title)}</b></caption>"
        f"{_row(head, 'th') if head else ''}{''.join(shown)}{rest}</table>"
    )


def _row(cells: Sequence[Any], tag: str) -> str:
    return "<tr>" + "".join(f"<{tag}{LEFT}>{html.escape(shown(cell))}</{tag}>" for cell in cells) + "</tr>"


def shown(value: Any) -> str:
    """Return a value in few characters."""
    if value is None:
        return "–"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list):
        return ", ".join(map(shown, value))
    if isinstance(value, dict):
        return ", ".join(f"{key}={shown(item)}" for key, item in value.items())
    return str(value)
