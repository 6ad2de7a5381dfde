"""mbs-ref history: what the nightly jobs measured, and where it changed."""

import html
from pathlib import Path

import click

from benchmarks import history
from benchmarks.history import Entry
from cross_checks.records import lines
from cross_checks.records.plots import new_figure
from mbs_ref.files import write_atomic
from reports import inputs
from reports.console import NothingSelected, complain, echo_json, number, show_table


@click.command(name="history", epilog="Example: mbs-ref history -o trends.html")
@click.option("--file", type=inputs.FILE, default="reports/out/history.jsonl", show_default=True, help="The lines.")
@click.option("--series", "text", default="", metavar="TEXT", help="Only series whose name holds this.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("-o", "output", metavar="FILE.html", help="Draw the trends.")
def command(file: Path, text: str, as_json: bool, output: str | None) -> None:
    """Show every series over time with its change points."""
    target = inputs.output(output, (".html",))
    entries, problems = lines.read(file, Entry)
    complain(problems)
    result = history.series(entries, text)
    if not result:
        raise NothingSelected(f"no series in {file} holds {text!r}")
    changes = {name: history.change_points([e.value for e in entries]) for name, entries in result.items()}
    if target is not None:
        write_trends(result, changes, target)
    if as_json:
        echo_json({name: {"values": [e.value for e in own], "changes": [own[k].made for k in changes[name]]}
                   for name, own in result.items()})  # fmt: skip
        return
    rows = []
    for name, entries in result.items():
        last, when = entries[-1], ", ".join(entries[k].made for k in changes[name])
        rows.append((name, len(entries), number(last.value), last.unit, last.verdict, when or "never"))
    show_table("", ("series", "jobs", "last", "unit", "verdict", "changed at"), rows)


TITLES = {"1": "ratio to the job's own baseline", "s": "time, s"}


def write_trends(series: dict[str, list[Entry]], changes: dict[str, list[int]], target: Path) -> None:
    """Write one page that works offline: a figure a unit, and a ring round the first value of each new level."""
    units = list(dict.fromkeys(entries[0].unit for entries in series.values()))
    parts = []
    for unit in units:
        own = {name: entries for name, entries in series.items() if entries[0].unit == unit}
        figure = _figure(own, changes, TITLES.get(unit, unit), y_log=unit != "1")
        parts.append(figure.to_html(full_html=False, include_plotlyjs=not parts))
    page = f"<!doctype html><meta charset='utf-8'><title>mbs-ref: trends</title>{''.join(parts)}"
    write_atomic(target, page.encode())


def _figure(series: dict[str, list[Entry]], changes: dict[str, list[int]], title: str, y_log: bool):
    figure = new_figure("time of the job, UTC", title, x_log=False, y_log=y_log)
    for name, entries in series.items():
        x, y = [e.made for e in entries], [e.value for e in entries]
        sentence = [html.escape(f"{e.commit_id} {e.verdict}".strip()) for e in entries]
        hover = "%{y:.4g}, %{x}<br>%{text}"
        figure.add_scatter(x=x, y=y, mode="lines+markers", name=html.escape(name), text=sentence, hovertemplate=hover)
        marked = changes[name]
        figure.add_scatter(
            x=[x[k] for k in marked], y=[y[k] for k in marked], mode="markers", showlegend=False,
            marker={"symbol": "circle-open", "size": 16, "color": "#c0392b"}, hovertext="the level changed here",
        )  # fmt: skip
    return figure
