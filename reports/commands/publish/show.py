"""mbs-ref show: a scene of the last report in the terminal."""

from pathlib import Path

import click

from cross_checks.judge.vocabulary import Refused, refusals
from cross_checks.records.record import known_error, loop_time, usable
from mbs_ref.scene.messages import suggest
from reports import inputs
from reports.console import NothingSelected, echo_json, show_table, text_plot
from reports.facts.report_data import ReportData
from reports.page.advice import advice
from reports.page.build import read_data
from reports.page.files import PRICES, VERDICTS, price_rows
from reports.page.sections.matrix import view
from reports.page.sections.overview import counted
from reports.poses_file import csv_table


@click.command(name="show", epilog="Example: mbs-ref show pendulum_chain links=10")
@click.argument("scene", nargs=-1)
@click.option("--csv", "as_csv", is_flag=True, help="Print the prices as CSV.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: cells and prices.")
@click.option("-o", "folder", default="reports/out", show_default=True, type=inputs.FOLDER, help="Where the report is.")
def command(scene: tuple[str, ...], as_csv: bool, as_json: bool, folder: Path) -> None:
    """Print the last report's results on SCENE. That is cost at equal error, and every verdict.

    A scene with parameters is named as the page names it: mbs-ref show pendulum_chain links=10
    """
    data = last_report(folder)
    for label in chosen(data, " ".join(scene)):
        _print(data.only(scenes=[label]), label, as_csv, as_json)


def last_report(folder: Path) -> ReportData:
    """Return the data of the last report in a folder; NothingSelected where there is none."""
    try:
        return read_data(folder)
    except (FileNotFoundError, ValueError) as error:
        raise NothingSelected(f"{folder} holds no report; mbs-ref report writes one") from error


def chosen(data: ReportData, wanted: str) -> list[str]:
    """Return the labels of the report's scenes of a label or name, all without one; UsageError where none is met."""
    result = [label for label in data.scenes if wanted in (label, label.split()[0])] if wanted else data.scenes
    if not result:
        listing = ", ".join(data.scenes)
        raise click.UsageError(
            f"scene {wanted!r} is not in the report{suggest(wanted, data.scenes)}; it holds {listing}"
        )
    return result


def _print(data: ReportData, label: str, as_csv: bool, as_json: bool) -> None:
    prices = price_rows(data, label)
    if as_json:
        rows = [dict(zip(PRICES, row, strict=True)) for row in prices]
        echo_json({"scene": label, "cells": [cell.to_dict() for cell in data.cells], "prices": rows})
    elif as_csv:
        columns = zip(*prices, strict=True) if prices else [[] for _ in PRICES]
        click.echo(csv_table({"scene": [label] * len(prices), **dict(zip(PRICES, columns, strict=True))}), nl=False)
    else:
        _tables(data, label, prices)


def price_plot(data: ReportData) -> str:
    """Return error against loop time in characters: each engine's runs that none of its own beats."""
    lines = {}
    for engine in data.engines:
        runs = sorted((loop_time(r) * 1e3, known_error(r)) for r in data.records if r.engine == engine and usable(r))
        best = [pair for k, pair in enumerate(runs) if all(pair[1] < other for _, other in runs[:k])]
        lines[engine] = ([ms for ms, _ in best], [error for _, error in best])
    return text_plot(lines, "loop time, ms", "error over the scene's scales", log_x=True, log_y=True)


def print_report(data: ReportData) -> None:
    """Print what the first screen says, then every scene."""
    head = ("engine", "use", "reaches", "wrong with success reported", "pace")
    rows = ((a.engine, a.use, a.reach, "; ".join(a.silent) or "none", a.pace or "-") for a in advice(data))
    show_table(counted(data), head, rows)
    for label in data.scenes:
        _print(data.only(scenes=[label]), label, as_csv=False, as_json=False)


def _tables(data: ReportData, label: str, prices: list[list[str]]) -> None:
    title = f"{label}: cost at equal error, over the scene's own scales"
    show_table(title, PRICES, prices)
    if plot := price_plot(data):
        click.echo(f"\n{plot}")
    views = [view(cell) for cell in data.cells if not cell.is_refused]
    show_table("\nVerdicts", VERDICTS, ([one[key] for key in VERDICTS.values()] for one in views))
    show_table("\nRefused", Refused._fields, refusals(data.cells))
