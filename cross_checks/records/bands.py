"""How an ensemble spreads over time: the band from the 5 % to the 95 % quantile, and the median in it."""

import html

from cross_checks.records.plots import COLOURS, Figure, new_figure
from mbs_ref.simulate.many.ensemble import Coordinate, Ensemble, Statistics, coordinates, statistics

HEIGHT = 300  # pixels of one coordinate
GAP = 0.06  # of the height, between two
SHOWN = 4  # lines that are drawn until others are chosen in the legend


def bands(ensemble: Ensemble) -> Figure:
    """Return a plot of each coordinate (m, rad) over time (s), of every body at every point of the grids."""
    named = coordinates(ensemble)
    kinds = list(dict.fromkeys((one.name, one.unit) for one in named))
    figure = new_figure("time, s", "", x_log=False, y_log=False, height=HEIGHT * len(kinds))
    figure.layout["legend"] |= {"groupclick": "togglegroup"}  # a body's coordinates come and go together
    first = figure.layout.pop("yaxis")
    for row, (name, unit) in enumerate(kinds):
        low = 1.0 - (row + 1) / len(kinds)
        domain = [low + (GAP if row + 1 < len(kinds) else 0.0), low + 1.0 / len(kinds)]
        figure.layout[_axis("yaxis", row)] = first | {"title": {"text": f"{name}, {unit}"}, "domain": domain}
    figure.layout["xaxis"] |= {"anchor": _axis("y", len(kinds) - 1)}
    points = [(result, at) for result, at in zip(statistics(ensemble), _points(ensemble), strict=True) if result]
    order = [(result, at, body) for body in ensemble.scene.body_names for result, at in points]
    for k, (result, at, body) in enumerate(order):
        for column, one in enumerate(named):
            if one.body == body:
                row = kinds.index((one.name, one.unit))
                _add(figure, k, row, f"{body} {at}".rstrip(), result, column, ensemble.times.tolist(), one)
    return figure


def _axis(kind: str, row: int) -> str:
    return kind if row == 0 else f"{kind}{row + 1}"


def _points(ensemble: Ensemble) -> list[str]:
    """Return each point of the grids in words."""
    design = ensemble.design
    return [", ".join(f"{name} = {value:.6g}" for name, value in zip(design.grids, at, strict=True))
            for at in design.points]  # fmt: skip


def _add(
    figure: Figure, k: int, row: int, name: str, result: Statistics, column: int, times: list[float], one: Coordinate
) -> None:
    """Add a median with the band about it; of a single run, its line alone."""
    colour = COLOURS[k % len(COLOURS)]
    low, median, high = result.quantiles[:, :, column].tolist()
    common = {"legendgroup": name, "yaxis": _axis("y", row), "name": html.escape(name),
              "visible": True if k < SHOWN else "legendonly"}  # fmt: skip
    if result.count > 1:
        figure.add_scatter(
            x=times + times[::-1], y=high + low[::-1], mode="lines", fill="toself", fillcolor=f"{colour}33",
            line={"width": 0}, hoverinfo="skip", showlegend=False, **common,
        )  # fmt: skip
    line = {"color": colour, "width": 2}
    figure.add_scatter(x=times, y=median, mode="lines", line=line, showlegend=one.name == "x", **common)
