"""A written script, run by an interpreter without our packages, prints the figures of our adapter."""

from __future__ import annotations

import ast
import csv
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from cross_checks import writers
from cross_checks.engine import Engine
from cross_checks.trajectory_files.column_map import own_map
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from reports.poses_file import write_poses
from tests.cross_checks.engines.engine_runs import engine

OURS = {"mbs_ref", "cross_checks", "benchmarks", "reports", "tests"}
ROUNDOFF = (
    1e-12  # of the largest number: the same arithmetic by the same libraries, and the sums of angles ordered anew
)
BETWEEN = "--- what the next script prints"
DATA = Path(__file__).parents[2] / "data"
SHORT = {"t_end": 0.1, "samples": 3}
# one run through every template, and those that need a part of it that no other does, are quick
QUICK = [
    ("exudyn", "pendulum", {}), ("exudyn", "spatial_chain", {}),
    ("exudyn", "double_pendulum", {"method": "tree_rk44"}), ("exudyn", "double_pendulum", {"method": "tree_dopri5"}),
    ("mujoco", "n_four_bar", {}), ("mujoco", "heavy_top", {}),
    ("pinocchio", "slider_crank", {"method": "rk4", "step": 0.01}),  # coarse, so that the gains matter
    ("pinocchio", "heavy_top", {}),
    ("drake", "double_pendulum", {}), ("drake", "heavy_top", {}),
]  # fmt: skip
TREES = ["pendulum", "double_pendulum", "pendulum_chain", "heavy_top", "torque_free_top", "spatial_chain"]
LOOPS = ["n_four_bar", "spatial_n_four_bar", "slider_crank"]
LOADED = ["spring_pendulum", "spherical_pendulum"]
ALL = [
    *(("exudyn", name, {}) for name in (*TREES, *LOOPS, *LOADED)),
    ("exudyn", "bouncing_ball", {"method": "contact_rk44"}),
    ("exudyn", "torque_free_top", {"method": "rotation_vector"}),
    ("exudyn", "double_pendulum", {"method": "trapezoidal"}),
    *(("exudyn", "pendulum_chain", {"method": f"tree_{name}"}) for name in ("dopri5", "rk44", "rk67", "euler")),
    *(("mujoco", name, {}) for name in (*TREES, *LOOPS, *LOADED)),
    *(("mujoco", "n_four_bar", {"method": name}) for name in ("euler", "implicit", "implicitfast", "rk4_tight")),
    *(("pinocchio", name, {}) for name in (*TREES, *LOOPS)),
    ("pinocchio", "slider_crank", {"method": "rk4_no_gains"}), ("pinocchio", "spatial_chain", {"method": "rk4"}),
    *(("drake", name, {}) for name in TREES),
    *(("drake", name, {"method": "sap"}) for name in LOOPS),
    ("drake", "double_pendulum", {"method": "runge_kutta3_fixed"}),
]  # fmt: skip


Printed = tuple[list[str], np.ndarray]  # header and rows


def printed(texts: Sequence[str], folder: Path) -> list[Printed]:
    """Run scripts where nothing of ours can be imported, in one interpreter; return what each of them prints."""
    # no import of our packages succeeds, however they are installed
    alone = f"import runpy, sys\nsys.modules.update(dict.fromkeys({sorted(OURS)}))\n"
    for k, text in enumerate(texts):
        (folder / f"script{k}.py").write_text(text)
        alone += f"print({BETWEEN!r})\nrunpy.run_path({str(folder / f'script{k}.py')!r}, run_name='__main__')\n"
    (folder / "alone.py").write_text(alone)
    done = subprocess.run([sys.executable, "-I", "alone.py"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    parts = [list(csv.reader(part.splitlines())) for part in done.stdout.split(f"{BETWEEN}\n")[1:]]
    return [(header, np.array(rows, dtype=float)) for header, *rows in parts]


def of_adapter(solver: Engine, scene: Scene, settings: Settings, folder: Path) -> Printed:
    """Return the same of our adapter."""
    path = solver.run(scene, settings)
    assert path.ok, path.message
    write_poses(path, scene.body_names, folder / "adapter.csv")
    header, *rows = csv.reader((folder / "adapter.csv").read_text().splitlines())
    return header, np.array(rows, dtype=float)


def assert_alike(solver: Engine, cases: Sequence[tuple[Scene, Settings]], folder: Path) -> None:
    texts = [writers.write(scene, solver.name, settings) for scene, settings in cases]
    for text in texts:
        tree = ast.parse(text)
        imports = [name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names]
        imports += [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        assert not {name.split(".")[0] for name in imports} & OURS
    for (scene, settings), (head, rows) in zip(cases, printed(texts, folder), strict=True):
        expected_head, expected = of_adapter(solver, scene, settings, folder)
        assert head == expected_head
        assert np.abs(rows - expected).max() <= ROUNDOFF * np.abs(expected).max(), (scene.name, settings)
        assert np.abs(rows[-1] - rows[0]).max() > 1e-3  # it moves


@pytest.mark.parametrize("name", dict.fromkeys(name for name, *_ in QUICK))
def test_scripts_alone_print_our_adapters_figures(name, tmp_path):
    cases = [(scenes.make(scene), Settings(**SHORT, **chosen)) for own, scene, chosen in QUICK if own == name]
    assert_alike(engine(name), cases, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "scene", "chosen"), ALL)
def test_every_kind_of_scene_and_method_as_a_script(name, scene, chosen, tmp_path):
    assert_alike(engine(name), [(scenes.make(scene), Settings(t_end=0.3, samples=4, **chosen))], tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["exudyn", "mujoco", "pinocchio", "drake"])
def test_a_robot_as_a_script(name, tmp_path):
    engine("pinocchio")
    from cross_checks.robots.pinocchio_ import read_urdf

    robot = read_urdf(DATA / "two_links_and_a_slider.urdf").scene
    assert_alike(engine(name), [(robot.model_copy(update={"loads": ()}), Settings(t_end=0.3, samples=4))], tmp_path)


@pytest.mark.slow
def test_contact_that_mujoco_has_itself_as_a_script(tmp_path):
    scene = scenes.make("bouncing_ball")
    (floor,) = scene.contacts
    pushing = floor.model_copy(update={"law": floor.law.model_copy(update={"release": "force"})})
    hopping = scene.model_copy(update={"contacts": (pushing,)})
    assert_alike(engine("mujoco"), [(hopping, Settings(t_end=0.3, samples=4))], tmp_path)


def test_a_script_that_stops_is_refused_with_its_last_line():
    engine("mujoco")
    growing = Settings(step=3.0, t_end=3000.0, samples=3, method="euler")
    with pytest.raises(writers.NotWritable, match="its script stops: MuJoCo reset its state before t ="):
        writers.write(scenes.make("spring_pendulum"), "mujoco", growing)


def test_what_a_script_prints_is_a_file_that_judge_reads_without_a_map():
    scene = scenes.make("heavy_top")
    engine("mujoco")
    line = next(x for x in writers.write(scene, "mujoco").splitlines() if x.startswith("COLUMNS"))
    columns = ast.literal_eval(line.partition("=")[2].partition("#")[0].strip())
    assert own_map(["t", *(f"{body}.{c}" for body in scene.body_names for c in columns)], scene.body_names) is not None


@pytest.mark.parametrize(
    ("name", "scene", "named"),
    [
        ("pinocchio", "kepler", "part type 'newton'"),
        ("pinocchio", "spring_pendulum", "load 'spring' (spring_damper)"),
        ("drake", "bouncing_ball", "contact 'floor' (circle_on_line)"),
        ("exudyn", "bouncing_ball", "contact 'floor' (circle_on_line)"),
        ("exudyn", "driven_pendulum", "drive 'drive' calls Python"),
        ("mujoco", "bouncing_ball", "contact 'floor'"),
        ("mujoco", "kepler", "part type 'newton'"),
    ],
)
def test_what_a_script_cannot_hold_is_named(name, scene, named):
    engine(name)
    with pytest.raises(writers.NotWritable) as refused:
        writers.write(scenes.make(scene), name)
    assert named in str(refused.value)


def test_an_unknown_form_says_what_is_allowed():
    with pytest.raises(ValueError, match=r"form = 'abaqus' is unknown; allowed: .*urdf"):
        writers.write(scenes.make("pendulum"), "abaqus")


def test_exudyn_records_at_every_output_and_repeats_sparse_elimination_in_large_loops_alone():
    engine("exudyn")
    even, uneven = (Settings(step=0.01, t_end=0.1, samples=count) for count in (3, 4))  # 5, 5 and 3, 4, 3 steps
    assert "EVERY = 1 " in writers.write(scenes.make("pendulum"), "exudyn", uneven)
    for loops, repeats in ((1, False), (12, True)):
        text = writers.write(scenes.make("n_four_bar", loops=loops), "exudyn", even)
        assert "EVERY = 5 " in text
        assert ("dense elimination begins anew" in text) is repeats
