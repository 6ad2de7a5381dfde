"""Performance profiles: the share of problems that a method solves within a factor of the best."""

from __future__ import annotations

from typing import Any

from benchmarks.profiles import Profile
from reports.drawing.plots.figure import add_series, lines, new_figure, to_data
from reports.drawing.plots.palette import Style

BEYOND = 2.0  # times the largest factor: where the axis ends
MOST = 1e4  # times the best: nobody waits longer


def profile_plot(profiles: list[Profile], styles: dict[tuple[str, str], Style]) -> dict[str, Any] | None:
    """Return the figure of rho(tau): factor of the best time across, share of problems up; None without any."""
    drawn = [profile for profile in profiles if profile.factors]
    if not drawn:
        return None
    end = min(MOST, BEYOND * max(profile.factors[-1] for profile in drawn))
    figure = new_figure("times the best loop time, tau", "share of the problems solved, rho", y_log=False)
    for profile in drawn:
        engine, method = profile.solver
        inner = [factor for factor in profile.factors if factor < end]
        x = [1.0, *inner, end]
        y = [profile.share(factor) for factor in x]
        text = [lines(f"{engine} · {method}", f"{share:.0%} within {factor:.3g} times the best") for factor, share in
                zip(x, y, strict=True)]  # fmt: skip
        add_series(figure, engine, method, styles[profile.solver], x, y, mode="lines", text=text,
                   hovertemplate="%{text}<extra></extra>")  # fmt: skip
        figure.data[-1]["line"] |= {"shape": "hv"}
    figure.update_yaxes(range=[0.0, 1.05], tickformat=".0%")
    return to_data(figure)
