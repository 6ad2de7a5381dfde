"""Laws and samples against the laws themselves, and everything that a person may mistype."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from mbs_ref.simulate.many.ensemble import Grid, Normal, Uniform, design, read_law

LAWS = {
    "1..2": Uniform(1.0, 2.0),
    "-2..-1": Uniform(-2.0, -1.0),
    "1.5..2.5e1": Uniform(1.5, 25.0),
    "0...5": Uniform(0.0, 0.5),
    "3+-0.5": Normal(3.0, 0.5),
    "-3+-1e-3": Normal(-3.0, 1e-3),
    "+-0.5": Normal(-8.0, 0.5),
    "+-5%": Normal(-8.0, 0.4),
    "2+-5%": Normal(2.0, 0.1),
    "1 .. 2": Uniform(1.0, 2.0),
    "0:1:5": Grid(0.0, 1.0, 5),
    "-1:1e3:2": Grid(-1.0, 1000.0, 2),
}


@pytest.mark.parametrize(("text", "law"), LAWS.items())
def test_a_law_is_read_as_it_is_written(text, law):
    read = read_law(text, own=-8.0)
    assert type(read) is type(law)
    assert vars(read) == pytest.approx(vars(law), rel=1e-15)


@pytest.mark.parametrize(
    ("text", "said"),
    [("2..1", "from 2 to 1 is no range"), ("1..1", "no range"), ("2:1:3", "no range"), ("1:2:1", "too small"),
     ("1+-0", "greater than 0"), ("1+--1", "greater than 0"), ("0+-5%", "5 % of 0"), ("1:2", "no law"),
     ("", "no law"), ("nan..1", "no law"), ("1..1e999", "beyond the largest"), ("1:2:2.5", "no law"),
     ("1...5", "from 1 to 0.5")],
)  # fmt: skip
def test_a_law_that_is_none_says_why(text, said):
    with pytest.raises(ValueError, match=said):
        read_law(text, own=1.0)


def test_what_is_about_an_own_value_needs_one():
    with pytest.raises(ValueError, match="a value of the scene"):
        read_law("+-1", own=None)


def test_samples_follow_their_laws_and_are_apart():
    """Every hundredth of a law has one of a hundred samples, and the laws know nothing of each other."""
    values = design({"a": Uniform(-1.0, 3.0), "b": Normal(5.0, 2.0)}, 1000, seed=3).values
    shares = stats.uniform(-1.0, 4.0).cdf(values[:, 0]), stats.norm(5.0, 2.0).cdf(values[:, 1])
    for share in shares:
        assert sorted((1000 * share).astype(int)) == list(range(1000))
    assert abs(stats.spearmanr(*shares).statistic) < 4.0 / np.sqrt(1000)  # four standard errors of it


def test_a_seed_gives_the_same_samples_always_and_another_gives_others():
    laws = {"a": Uniform(0.0, 1.0), "b": Normal(0.0, 1.0)}
    first, again, other = (design(laws, 20, seed).values for seed in (7, 7, 8))
    assert np.array_equal(first, again)
    assert not np.any(first == other)


def test_grids_make_their_product_and_random_laws_stand_at_each_point():
    made = design({"a": Grid(0.0, 1.0, 2), "u": Uniform(0.0, 1.0), "b": Grid(5.0, 7.0, 3)}, 4)
    assert made.points.tolist() == [[0, 5], [0, 6], [0, 7], [1, 5], [1, 6], [1, 7]]
    assert made.values.shape == (24, 3)
    for k, point in enumerate(made.points):
        here = made.values[made.runs_at(k)]
        assert np.array_equal(here[:, [0, 2]], np.tile(point, (4, 1)))
        assert np.array_equal(here[:, 1], made.values[:4, 1])
    assert "2 x 3 values" in made.sentence()
    assert "seed 0" in made.sentence()


@pytest.mark.parametrize(
    ("laws", "count", "seed", "said"),
    [({}, None, 0, "nothing is varied"), ({"u": Uniform(0, 1)}, 0, 0, "n = 0"), ({"u": Uniform(0, 1)}, 1, 0, "n = 1"),
     ({"g": Grid(0, 1, 2)}, 5, 0, "n = 5"), ({"u": Uniform(0, 1)}, 5, -1, "seed = -1"),
     ({"g": Grid(0, 1, 10**5), "h": Grid(0, 1, 10**5)}, None, 0, "10000000000 runs")],
)  # fmt: skip
def test_counts_that_make_no_sense_are_refused(laws, count, seed, said):
    with pytest.raises(ValueError, match=said):
        design(laws, count, seed)
