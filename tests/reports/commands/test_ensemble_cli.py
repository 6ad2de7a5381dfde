"""mbs-ref ensemble: what it prints, writes and draws, and its exit codes."""

from __future__ import annotations

import csv
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from click.testing import CliRunner, Result

from cross_checks.records.bands import bands
from mbs_ref import scenes
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.toml import write_scene
from mbs_ref.settings import Settings
from mbs_ref.simulate.many import ensemble as ensembles
from mbs_ref.simulate.many.ensemble import runs
from reports.cli import main
from reports.commands.run import ensemble as command

QUICK = ("--t-end", "0.2", "--samples", "3", "--threads", "1")


def run(*words: str) -> Result:
    return CliRunner().invoke(main, ["ensemble", *words], prog_name="mbs-ref")


def test_it_speaks_to_a_person():
    done = run("double_pendulum", "--vary", "angle_2=+-5%", "-n", "6", *QUICK)
    assert done.exit_code == 0, done.output
    for said in ("angle_2: normal, mean 0.5, standard deviation 0.025", "std. deviation", "angle, rad", "seed 0",
                 "6 runs: 6 success", "estimated integration error", "runs/s", "2 degrees of freedom"):  # fmt: skip
        assert said in done.stdout, said


def test_json_holds_inputs_ends_and_statistics_and_the_seed_makes_them_again():
    words = ("double_pendulum", "--vary", "angle_2=+-5%", "-n", "6", "--seed", "4", "--json", *QUICK)
    first, again = (json.loads(run(*words).stdout) for _ in range(2))
    for one in (first, again):
        assert one.pop("wall_s") > 0.0 < one.pop("runs_per_s")
    assert first == again
    assert first["counts"] == {"success": 6}
    (point,) = first["points"]
    angle = point["bodies"]["lower"]["angle"]
    drawn = [one["values"]["angle_2"] for one in first["runs"]]
    assert angle["mean"][0] == pytest.approx(np.mean(drawn))
    assert angle["standard_deviation"][0] == pytest.approx(np.std(drawn, ddof=1))
    assert angle["50 %"][0] == pytest.approx(np.median(drawn))
    assert [angle["least"][0], angle["most"][0]] == pytest.approx([min(drawn), max(drawn)])


def test_a_grid_needs_no_count_and_shows_each_value():
    done = run("pendulum", "--vary", "length=0.5:2:4", *QUICK)
    assert done.exit_code == 0, done.output
    assert "a grid of 4 values" in done.stdout
    rows = [line.split() for line in done.stdout.splitlines() if " bob " in line]
    assert [row[0] for row in rows] == ["0.5", "1", "1.5", "2"]
    assert [np.hypot(float(row[2]), float(row[3])) for row in rows] == pytest.approx([0.5, 1.0, 1.5, 2.0], rel=1e-7)


def test_a_file_has_numbers_and_no_parameters(tmp_path):
    file = tmp_path / "mine.toml"
    write_scene(scenes.make("pendulum"), file)
    assert run(str(file), "--vary", "bob.mass=1..2", "-n", "3", *QUICK).exit_code == 0
    done = run(str(file), "--vary", "length=1..2", "-n", "3", *QUICK)
    assert done.exit_code == 2
    assert "parameters of" not in done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [((), "nothing is varied"), (("--vary", "lenth=1..2"), "did you mean 'length'"),
     (("--vary", "bob.mas=1..2"), "did you mean 'mass'"), (("--vary", "length"), "must be WHAT=LAW"),
     (("--vary", "length=2..1"), "from 2 to 1 is no range"), (("--vary", "length=long"), "is no law; allowed: LOW"),
     (("--vary", "length=1..2", "-n", "0"), "n = 0"), (("--vary", "length=1:2:3", "-n", "9"), "no law is random"),
     (("--vary", "length=1..2", "--vary", "length=1..2"), "given twice"),
     (("--vary", "length=1..2", "-o", "x.txt"), "allowed: .npz, .csv, .parquet"),
     (("--vary", "length=1..2", "--method", "rk5"), "rk5"), (("--vary", "length=1..2", "--samples", "1"), "samples"),
     (("--vary", "bob.position.x=+-0.1", "--keep", "bob.velocity"), "varies a pose"),
     (("--vary", "length=1..2", "--keep", "bab.velocity"), "bab.velocity")],
)  # fmt: skip
def test_what_makes_no_sense_is_a_sentence_and_exit_code_2(words, said):
    done = run("pendulum", *words, "--t-end", "0.1")
    assert done.exit_code == 2, done.output
    assert said in done.stderr


def test_a_small_spread_of_a_large_number_is_seen(tmp_path):
    bob = PointMass(name="bob", mass=1.0, position=(0.0, 0.0), velocity=(0.0, 0.0))
    write_scene(Scene(name="far", bodies=(bob,)), tmp_path / "far.toml")
    done = run(str(tmp_path / "far.toml"), "--vary", "bob.position.x=1e6..1000001", "-n", "10", *QUICK)
    (row,) = [line.split() for line in done.stdout.splitlines() if line.split()[:2] == ["bob", "x,"]]
    mean, *_, least, most = (float(word) for word in row[3:])
    assert mean == pytest.approx(1e6 + 0.5, abs=0.03)
    assert 0.0 <= least - 1e6 <= 0.1
    assert 0.9 <= most - 1e6 <= 1.0


def test_where_no_run_ends_well_the_exit_code_says_so():
    done = run("slider_crank", "--vary", "crank.angular_velocity=+-1", "-n", "3", *QUICK)
    assert done.exit_code == 1
    assert "3 inconsistent" in done.stdout
    assert "no run ended well" in done.stderr


def test_an_interrupted_one_shows_what_there_is(monkeypatch):
    original, calls = runs.simulate_starts, []

    def once(*arguments, **keywords):
        if calls:
            raise KeyboardInterrupt
        calls.append(1)
        return original(*arguments, **keywords)

    monkeypatch.setattr(runs, "simulate_starts", once)
    done = run("double_pendulum", "--vary", "lower.velocity.x=+-1", "--project-initial", "-n", "30", *QUICK)
    assert done.exit_code == 4
    assert "std. deviation" in done.stdout
    assert "interrupted after" in done.stderr


@pytest.fixture(scope="module")
def made():
    scene = scenes.make("double_pendulum")
    source = ensembles.Source(scene)
    laws = {"lower.mass": ensembles.Normal(0.3, 0.3), "gravity.y": ensembles.Grid(-2.0, -1.0, 2)}
    variants = ensembles.Variants(source, [source.target(name) for name in laws])
    return ensembles.run_ensemble(variants, ensembles.design(laws, 8), Settings(t_end=0.1, samples=3), threads=1)


def test_files_hold_inputs_and_samples(tmp_path):
    words = ("pendulum", "--vary", "length=0.5:2:4", "--vary", "mass=-1:1:2", *QUICK)  # half of them without a mass
    for suffix in ("npz", "csv"):
        assert run(*words, "-o", str(tmp_path / f"all.{suffix}")).exit_code == 0
    with np.load(tmp_path / "all.npz") as file:
        arrays = dict(file)
    assert arrays["inputs"].tolist() == ["length", "mass"]
    assert arrays["position"].shape == (8, 3, 1, 2)
    assert np.isnan(arrays["position"][arrays["status"] == "refused"]).all()
    good = arrays["status"] == "success"
    assert good.sum() == 4
    lengths = np.linalg.norm(arrays["position"][good][:, :, 0], axis=2)
    assert lengths == pytest.approx(np.repeat(arrays["values"][good, :1], 3, axis=1), rel=1e-9)
    rows = list(csv.DictReader((tmp_path / "all.csv").read_text().splitlines()))
    assert len(rows) == 8 * 3
    assert [float(row["bob.x"]) for row in rows] == pytest.approx(arrays["position"][:, :, 0, 0].ravel(), nan_ok=True)
    assert {row["vary length"] for row in rows} == {"0.5", "1.0", "1.5", "2.0"}


def test_a_table_of_columns_reads_back(made, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    from reports.poses_file import write_ensemble

    write_ensemble(made, tmp_path / "all.parquet")
    table = parquet.read_table(tmp_path / "all.parquet").to_pydict()
    assert table["vary gravity.y"] == np.repeat([-2.0, -1.0], 24).tolist()
    assert table["lower.x"] == pytest.approx(made.samples.position[:, :, 1, 0].ravel().tolist(), nan_ok=True)


def test_a_plot_has_a_band_and_a_median_of_every_coordinate_at_every_point(made):
    figure = bands(made)
    drawn = go.Figure({"data": figure.data, "layout": figure.layout})  # which checks every property
    found = ensembles.statistics(made)
    assert len(drawn.data) == 2 * 2 * 2 * 3  # lines and bands, points, bodies, coordinates
    lines = [line for line in drawn.data if line.fill is None]
    assert lines[0].name == "upper gravity.y = -2"
    assert np.allclose(lines[0].y, found[0].quantiles[1, :, 0])
    band = next(line for line in drawn.data if line.fill == "toself")
    assert np.allclose(band.y, [*found[0].quantiles[2, :, 0], *found[0].quantiles[0, ::-1, 0]])
    assert all(line.legendgroup == line.name for line in drawn.data)
    assert drawn.layout.legend.groupclick == "togglegroup"
    assert [drawn.layout[axis].title.text for axis in ("yaxis", "yaxis2", "yaxis3")] == ["x, m", "y, m", "angle, rad"]


def test_a_page_is_written(tmp_path):
    page = tmp_path / "plot.html"
    assert run("pendulum", "--vary", "length=1:2:2", "--plot", str(page), *QUICK).exit_code == 0
    assert "bob length = 2" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(("lost", "shown"), [((), True), ((0,), True), ((0, 1), True), ((0, 1, 2), False)])
def test_figures_at_the_end_are_those_of_the_runs_that_ended_well(monkeypatch, capsys, lost, shown):
    ended = np.array([k not in lost for k in range(3)])
    built: Any = SimpleNamespace(
        ended_well=ended, design=SimpleNamespace(laws={"mass": "1..2"}), runs_per_s=2.5, wall_s=4.0)  # fmt: skip
    monkeypatch.setattr(command.ensembles, "statistics", lambda built: "figures")
    monkeypatch.setattr(command.ensembles, "account", lambda built, result: [f"{ended.sum()} of 3 ended well"])
    monkeypatch.setattr(command, "end_table", lambda built, result: (f"table of {result}", 7 * len(lost)))
    monkeypatch.setattr(command, "show", print)
    command._show(built)
    more = f"and {7 * len(lost)} rows more: --json, -o and --plot have them"
    table = ["table of figures", *([more] if lost else []), ""] if shown else []
    speed = "2.5 runs/s, 4 s in all, error estimates included"
    shown_lines = capsys.readouterr().out.splitlines()
    assert shown_lines == ["mass: 1..2", *table, f"{ended.sum()} of 3 ended well", speed]
