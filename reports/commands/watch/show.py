"""mbs-ref show: a scene of the last report in the terminal."""

from __future__ import annotations

import csv
import io
import sys
from dataclasses import asdict
from pathlib import Path

import click

from mbs_ref.scene.messages import suggest
from reports.console import echo_json, show, table
from reports.exit_codes import NothingSelected
from reports.facts.report_data import ReportData
from reports.page.files import PRICES, price_row
from reports.page.publish import read_data
from reports.page.sections.matrix import refused, view
from reports.page.sections.prices import price_table

FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command(name="show")
@click.argument("scene", nargs=-1)
@click.option("--csv", "as_csv", is_flag=True, help="Print the prices as CSV.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: cells and prices.")
@click.option("-o", "folder", default="reports/out", show_default=True, type=FOLDER, help="Where the report is.")
def command(scene: tuple[str, ...], as_csv: bool, as_json: bool, folder: Path) -> None:
    """Print what the last report says of SCENE: cost at equal error, and the verdict on every method.

    A scene with parameters is named as the page names it: mbs-ref show pendulum_chain links=10
    """
    data = last_report(folder)
    for label in _chosen(data, " ".join(scene)):
        _print(data.only(scene=label), label, as_csv, as_json)


def last_report(folder: Path) -> ReportData:
    """Return the data of the last report in a folder; NothingSelected where there is none."""
    try:
        return read_data(folder)
    except (FileNotFoundError, ValueError) as error:
        raise NothingSelected(f"{folder} holds no report; make one by mbs-ref report") from error


def _chosen(data: ReportData, asked: str) -> list[str]:
    found = [label for label in data.scenes if asked in (label, label.split()[0])] if asked else data.scenes
    if not found:
        listing = ", ".join(data.scenes)
        raise click.UsageError(f"scene {asked!r} is not in the report{suggest(asked, data.scenes)}; it holds {listing}")
    return found


def _print(data: ReportData, label: str, as_csv: bool, as_json: bool) -> None:
    prices = [price_row(block["target"], row) for block in price_table(data, label) for row in block["rows"]]
    if as_json:
        rows = [dict(zip(PRICES, row, strict=True)) for row in prices]
        echo_json({"scene": label, "cells": [asdict(cell) for cell in data.cells], "prices": rows})
    elif as_csv:
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows([["scene", *PRICES], *([label, *row] for row in prices)])
        sys.stdout.write(out.getvalue())
    else:
        _tables(data, label, prices)


def _tables(data: ReportData, label: str, prices: list[list[str]]) -> None:
    listing = table(f"{label}: cost at equal error, over the scene's own scales", *PRICES)
    for row in prices:
        listing.add_row(*row)
    show(listing)
    verdicts = table("\nVerdicts", "engine", "method", "verdict", "error", "setting", "why")
    for cell in data.cells:
        if cell.verdict not in ("cannot", "engine-missing"):
            seen = view(cell)
            verdicts.add_row(*(seen[key] for key in ("engine", "method", "word", "error", "setting", "reason")))
    show(verdicts)
    out = table("\nNo part take", "engine", "methods", "because")
    for row in refused(data):
        out.add_row(row["engine"], row["methods"], row["reason"])
    show(out)
