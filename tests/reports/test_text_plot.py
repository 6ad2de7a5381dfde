import numpy as np

from reports.terminal.text_plot import HEIGHT, WIDTH, text_plot


def field(plot: str) -> list[str]:
    """The rows of the field without the frame, padded."""
    return [row.split("|", 1)[1].ljust(WIDTH) for row in plot.splitlines()[1 : HEIGHT + 1]]


def test_a_straight_line_runs_from_the_lower_left_to_the_upper_right():
    x = np.linspace(0.0, 5.0, 500)
    rows = field(text_plot({"line": (x, 3.0 * x - 1.0)}, "x", "y"))
    assert (rows[0][-1], rows[-1][0]) == ("o", "o")
    first = [row.index("o") for row in rows]
    assert first == sorted(first, reverse=True)


def test_a_power_is_straight_on_logarithmic_axes_and_what_has_no_logarithm_is_left_out():
    x = np.array([0.0, 1.0, 10.0, 100.0])
    plot = text_plot({"power": (x, x**2)}, "x", "y", log_x=True, log_y=True)
    places = [(k, row.index("o")) for k, row in enumerate(field(plot)) if "o" in row]
    assert places == [(0, WIDTH - 1), (7, 36), (HEIGHT - 1, 0)]
    assert "1e+04" in plot


def test_nothing_finite_draws_nothing():
    assert text_plot({"void": ([np.nan], [1.0])}, "x", "y") == ""
