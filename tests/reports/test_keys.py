"""Keys of stored answers: whatever an answer depends on changes its key."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks import engines, truths
from cross_checks.engine import Engine
from cross_checks.judge.answers import Question
from cross_checks.records import store
from cross_checks.truths import of
from mbs_ref import scenes
from mbs_ref.settings import Settings
from reports import gather
from reports.facts import compiling, stored
from reports.facts.curves import Measured
from reports.studies import study

SCENE = scenes.make("andrews")
TIMES = np.array([0.0, 0.3, 1.0])
FINE = Settings(method="rk4", step=0.01)


def _keys() -> tuple[str, str]:
    stored.engine_keys.cache_clear()
    return stored._question_key(Question(SCENE, "mbs_ref", None), full=False), stored.truth_key(SCENE)


@pytest.fixture(autouse=True)
def _fresh():
    yield
    stored.engine_keys.cache_clear()


def test_an_upgrade_of_another_engine_changes_the_keys_of_all_answers(monkeypatch):
    before = _keys()
    monkeypatch.setattr(type(engines.get("rebound")), "version", lambda self: "99")
    assert all(new != old for new, old in zip(_keys(), before, strict=True))


def test_another_adapter_in_another_environment_changes_a_key(monkeypatch):
    before = _keys()
    monkeypatch.setattr(type(engines.get("rebound")), "made_of", "another")
    assert _keys()[0] != before[0]


def test_other_stored_poses_change_a_truth_and_its_answers(monkeypatch, tmp_path):
    times = np.linspace(0.0, SCENE.duration, 3)
    keys, name = _keys(), store.truth_name(SCENE, times)
    assert store.file_of(SCENE).is_file()
    poses = tmp_path / "poses.npz"
    poses.write_bytes(store.file_of(SCENE).read_bytes() + b"0")
    monkeypatch.setattr(store, "file_of", lambda scene: poses)
    assert store.truth_name(SCENE, times) != name
    assert all(new != old for new, old in zip(_keys(), keys, strict=True))


def modules_in(package: Any) -> list[str]:
    return [f"{package.__name__}.{info.name}" for info in pkgutil.iter_modules(package.__path__)]


def capabilities(monkeypatch) -> str:
    """Return the key of what engines can model."""
    keys: list[str] = []
    monkeypatch.setattr(stored, "remembered", lambda store, key, kind, make: keys.append(key) or ())
    monkeypatch.setattr(stored, "recall", lambda *given: None)
    monkeypatch.setattr(gather.Gathering, "mechanism", lambda self, label, scene: SimpleNamespace(scene=label))
    gather.Gathering(None, scenes=("pendulum",)).beyond(gather.ReportData((), ()))  # type: ignore[arg-type]
    return keys[0]  # a part of a report has no extremes


def study_of_trust(monkeypatch) -> str:
    """Return the key of a study's facts."""
    keys: list[str] = []
    monkeypatch.setattr(study, "recall", lambda store, key, kind: keys.append(key) or Measured())
    document = study.every()["trust"]
    monkeypatch.setattr(study, "every", lambda: {"trust": document})
    study.measure_all(None, {}, (), lambda *given: None)  # type: ignore[arg-type]
    return keys[0]


ADAPTER = type(engines.get("mbs_ref")).__module__
OF_TRUTHS = [*modules_in(of)[::5], truths.__name__]
KEYS: dict[str, tuple[Callable[[Any], str], list[str]]] = {  # with modules whose code it depends on
    "run": (lambda _: store.run_name(SCENE, engines.get("mbs_ref"), FINE, TIMES),
            ["cross_checks.judge.measure", ADAPTER, Engine.__module__]),
    "truth": (lambda _: store.truth_name(SCENE, TIMES), OF_TRUTHS),
    "answer": (lambda _: stored._question_key(Question(SCENE, "mbs_ref", None), full=False),
               ["cross_checks.judge.cell", ADAPTER, Engine.__module__, *OF_TRUTHS[-1:]]),
    "facts of a truth": (lambda _: stored.truth_key(SCENE),
                         ["cross_checks.judge.cell", "reports.facts.scene_facts", ADAPTER, *OF_TRUTHS[-1:]]),
    "facts of a scene": (lambda _: stored.scene_key(SCENE), ["reports.facts.scene_facts", *OF_TRUTHS[-1:]]),
    "capabilities": (capabilities, ["cross_checks.judge.capabilities", ADAPTER]),
    "kernels": (lambda _: compiling._key("plane", compiling.SOLVER), [ADAPTER]),
    "study": (study_of_trust, ["reports.studies.trust"]),
}  # fmt: skip


def _fresh_digests() -> None:
    stored.engine_keys.cache_clear()
    stored._judge.cache_clear()


@pytest.mark.parametrize(("what", "module"), [(what, module) for what, (_, own) in KEYS.items() for module in own])
def test_other_code_of_what_is_stored_is_another_key(monkeypatch, what, module):
    make, _ = KEYS[what]
    _fresh_digests()
    with monkeypatch.context() as patch:
        before = make(patch)
    for place in (store, stored, gather, study, compiling):
        for name in ("code_of", "source_digest"):
            if (digest := getattr(place, name, None)) is not None:
                changed = lambda one, digest=digest: "another" if one == module else digest(one)  # noqa: E731
                monkeypatch.setattr(place, name, changed)
    _fresh_digests()
    after = make(monkeypatch)
    monkeypatch.undo()
    _fresh_digests()
    assert after != before


def test_every_input_of_what_is_stored_is_in_its_key(monkeypatch):
    other, engine = SCENE.model_copy(update={"gravity": (0.0, -1.0)}), engines.get("mbs_ref")
    method = engine.method("rk4")
    questions = [Question(SCENE, "mbs_ref", None), Question(SCENE, "mbs_ref", method), Question(SCENE, "rebound", None),
                 Question(SCENE, "mbs_ref", engine.method("euler")), Question(other, "mbs_ref", None)]  # fmt: skip
    keys = [stored._question_key(one, full) for one in questions for full in (False, True)]
    keys += [key(scene) for key in (stored.truth_key, stored.scene_key) for scene in (SCENE, other)]
    runs = [(SCENE, FINE, TIMES), (other, FINE, TIMES), (SCENE, Settings(method="rk4", step=0.02), TIMES),
            (SCENE, Settings(method="euler", step=0.01), TIMES), (SCENE, FINE, TIMES[::2])]  # fmt: skip
    keys += [store.run_name(scene, engine, settings, times) for scene, settings, times in runs]
    keys += [store.truth_name(scene, times) for scene, _, times in (*runs[:2], *runs[4:])]
    keys += [compiling._key(core, compiling.SOLVER) for core in compiling.CORES]
    monkeypatch.setattr(stored, "TARGETS", (0.5,))
    stored._judge.cache_clear()
    keys += [stored._question_key(questions[0], False), stored.truth_key(SCENE)]
    stored._judge.cache_clear()
    assert len(set(keys)) == len(keys)
