"""Records and samples as data frames; what a notebook shows of them; the names that a program uses."""

from __future__ import annotations

import importlib
import subprocess
import sys

import numpy as np
import pytest

import cross_checks
import mbs_ref
from mbs_ref.display import MOST_ROWS, listing

SCENE = mbs_ref.scenes.make("pendulum")


@pytest.fixture(scope="module")
def run():
    return cross_checks.run(SCENE, step=0.01, method="rk4", t_end=0.2, samples=3, estimate="off")


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_frame_has_a_row_a_run_and_dotted_columns(run, library):
    pytest.importorskip(library)
    frame = cross_checks.frame([run, run.record], library=library)
    assert len(frame) == 2
    assert frame["error.value"][1] == run.record.error.value
    assert frame["settings.step"][0] == 0.01
    assert not [name for name in frame.columns if name.startswith(("history", "final"))]


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_samples_are_named_as_the_files_are(run, library):
    pytest.importorskip(library)
    frame = cross_checks.samples(SCENE, run.path, library=library)
    assert list(frame.columns) == ["t", *(f"bob.{word}" for word in ("x", "y", "angle", "vx", "vy", "rate"))]
    assert np.array_equal(np.array(frame["bob.vy"]), run.path.velocity[:, 0, 1])


def test_an_unknown_or_missing_library_says_what_to_do(run, monkeypatch):
    with pytest.raises(ValueError, match="library = 'excel' is unknown; allowed: pandas, polars"):
        cross_checks.frame([run], library="excel")

    def absent(name, *_):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr(importlib, "import_module", absent)
    from cross_checks.records.frames import frame

    with pytest.raises(ImportError, match="need the package polars: pip install polars"):
        frame([run], library="polars")


def test_everything_shows_itself(run):
    assert "bob" in SCENE._repr_html_()
    assert "0.2 s, 3 samples of 1 bodies" in run.path._repr_html_()
    assert f"{run.record.error.value:.2g} of the scene" in run._repr_html_()
    refused = cross_checks.run(mbs_ref.scenes.make("kepler"), "dart") if "dart" in cross_checks.engines.names() else run
    assert refused.record.status in refused._repr_html_()


def test_what_is_shown_is_escaped_and_short():
    told = listing("<b>", ("a",), [(f"<{k}>",) for k in range(MOST_ROWS + 3)])
    assert "&lt;b&gt;" in told
    assert "<0>" not in told
    assert "and 3 more" in told


def test_verdicts_are_a_table(tmp_path, monkeypatch):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "store.sqlite"))
    cells = cross_checks.check(SCENE, ["opensim"])
    assert "opensim" in cells._repr_html_()
    assert cells[0]._repr_html_().startswith("<table>")


@pytest.mark.parametrize("package", [mbs_ref, cross_checks])
def test_public_names_are_there_and_others_say_which_are(package):
    for name in dir(package):
        assert getattr(package, name) is not None
    with pytest.raises(AttributeError, match="public are "):
        _ = package.nothing


def test_a_function_and_the_package_of_its_name_are_one_attribute():
    path = mbs_ref.simulate(SCENE, mbs_ref.Settings(t_end=0.1, samples=2))
    assert path.ok
    assert importlib.import_module("mbs_ref.simulate") is mbs_ref.simulate


@pytest.mark.parametrize("package", [mbs_ref, cross_checks])
def test_no_public_name_is_imported_with_its_package(package):
    code = f"import sys, {package.__name__}; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_another_system_than_linux_is_refused_by_name():
    code = "import sys; sys.platform = 'darwin'; import mbs_ref"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "ImportError: mbs-ref needs Linux, and this system is darwin" in done.stderr


def test_an_unknown_setting_or_engine_is_named():
    with pytest.raises(ValueError, match="stepp: is no field here"):
        cross_checks.run(SCENE, stepp=0.1)
    with pytest.raises(ValueError, match="engine = 'adams' is unknown"):
        cross_checks.run(SCENE, "adams")
