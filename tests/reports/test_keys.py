"""Keys of stored answers: whatever an answer depends on changes its key."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.judge.answers import Question
from cross_checks.records import store
from mbs_ref import scenes
from reports.facts import stored

SCENE = scenes.make("andrews")


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
