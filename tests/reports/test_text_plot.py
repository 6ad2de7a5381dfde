import numpy as np
import pytest

from reports.console import HEIGHT, WIDTH, text_plot


def field(plot: str) -> list[str]:
    """The rows of the field without the frame, padded."""
    return [row.split("|", 1)[1].ljust(WIDTH) for row in plot.splitlines()[1 : HEIGHT + 1]]


@pytest.mark.parametrize("log_x", [False, True])
@pytest.mark.parametrize("log_y", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_every_mark_stands_where_its_point_is(seed, log_x, log_y):
    """Points of several lines, some of them not to be drawn; axes end at the least and the largest that are."""
    rng, marks = np.random.default_rng(seed), "ox+*#@%&"
    lines = {f"line {k}": (10 ** rng.uniform(-3, 3, 5), 10 ** rng.uniform(-3, 3, 5)) for k in range(3)}
    for x, y in lines.values():
        x[1], y[2] = np.nan, np.inf
        y[3] *= -1.0
    lines["none"] = ([], [])  # type: ignore[assignment]
    plot = text_plot(lines, "across", "up", log_x=log_x, log_y=log_y)
    points = [(k, x, y) for k, (xs, ys) in enumerate(lines.values()) for x, y in zip(xs, ys, strict=True)
              if np.isfinite([x, y]).all() and (y > 0.0 or not log_y)]  # fmt: skip
    scaled = [(np.log10(x) if log_x else x, np.log10(y) if log_y else y) for _, x, y in points]
    (low_x, low_y), (high_x, high_y) = np.min(scaled, axis=0), np.max(scaled, axis=0)
    drawn: dict[tuple[int, int], str] = {}
    for (k, *_), (x, y) in zip(points, scaled, strict=True):
        column = round((x - low_x) / (high_x - low_x) * (WIDTH - 1))
        row = round((y - low_y) / (high_y - low_y) * (HEIGHT - 1))
        drawn[HEIGHT - 1 - row, column] = marks[k]
    rows = field(plot)
    assert {(i, j): mark for i, row in enumerate(rows) for j, mark in enumerate(row) if mark != " "} == drawn
    texts = plot.splitlines()
    assert len({text.index("|") for text in texts[1 : HEIGHT + 1]} | {texts[HEIGHT + 1].index("+")}) == 1
    xs, ys = [x for _, x, _ in points], [y for *_, y in points]
    assert texts[0] == "up"
    assert [texts[1].split("|")[0].strip(), texts[HEIGHT].split("|")[0].strip()] == [f"{max(ys):.3g}", f"{min(ys):.3g}"]
    assert texts[HEIGHT + 2].split() == [f"{min(xs):.3g}", f"{max(xs):.3g}"]
    assert {len(texts[HEIGHT + 1]), len(texts[HEIGHT + 2])} == {texts[1].index("|") + 1 + WIDTH}
    assert (texts[-2].strip(), texts[-1].strip()) == ("across", "o line 0   x line 1   + line 2")


def test_a_power_is_straight_on_logarithmic_axes_and_what_has_no_logarithm_is_left_out():
    x = np.array([0.0, 1.0, 10.0, 100.0])
    plot = text_plot({"power": (x, x**2)}, "x", "y", log_x=True, log_y=True)
    places = [(k, row.index("o")) for k, row in enumerate(field(plot)) if "o" in row]
    assert places == [(0, WIDTH - 1), (7, 36), (HEIGHT - 1, 0)]
    assert "1e+04" in plot


def test_nothing_finite_draws_nothing():
    assert text_plot({"void": ([np.nan], [1.0])}, "x", "y") == ""
