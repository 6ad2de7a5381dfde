"""Tables of the site: what engines take, how well truths are known, from made-up capabilities and the certificates."""

from __future__ import annotations

import random

import pytest

from cross_checks.engine.method import Method
from cross_checks.judge.capabilities import Capability
from cross_checks.truths import certificate
from mbs_ref.scene.traits import PART_TYPES
from reports.site import gallery


def rows_of(text: str) -> list[list[str]]:
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


@pytest.mark.parametrize("seed", range(2))
def test_what_each_engine_can(monkeypatch, seed):
    chance, scenes, able = random.Random(seed), ("kepler", "andrews", "pendulum"), []
    for name in ("zeta", "alpha"):
        parts = {kind: chance.random() < 0.5 for kind in PART_TYPES}
        runs = {scene: ("why",) * chance.randint(0, 1) for scene in scenes}
        methods = tuple(Method(f"{name}{k}", "fixed", 2, "") for k in range(3))
        able.append(Capability(name, True, "", f"{name} 1", methods, parts, runs))
    gone = Capability("gone", False, "needs | a package")
    monkeypatch.setattr(gallery, "capabilities", lambda: (able[0], gone, able[1]))
    text = gallery.capability_page()
    rows = rows_of(text)
    for one in able:
        assert [one.engine, one.version, ", ".join(method.name for method in one.methods)] in rows
    for kind in PART_TYPES:
        assert [f"`{kind}`", *("yes" if one.parts[kind] else "-" for one in able)] in rows
    for scene in scenes:
        assert [f"`{scene}`", *("-" if one.scenes[scene] else "yes" for one in able)] in rows
    assert [row[0] for row in rows if row[0].strip("`") in scenes] == ["`andrews`", "`kepler`", "`pendulum`"]
    assert "- `gone`: needs | a package" in text
    for scene in (*scenes, "unknown"):
        assert gallery.who_can(scene, (*able, gone)) == ", ".join(
            one.engine for one in able if one.scenes.get(scene) == ())  # fmt: skip


def test_how_well_truths_are_known():
    rows = rows_of(gallery.truth_page())
    assert rows[0] == ["scene", "kind", "known to, m", "our solver within, m", "how"]
    stored = certificate.every()
    assert len(rows) == len(stored) + 2 > 10
    for row, one in zip(rows[2:], stored, strict=True):
        assert row[0].split()[0] == f"`{one.scene}`"
        assert row[0].split()[1:] == [f"{key}={value}" for key, value in one.parameters.items()]
        within = "-" if one.confirmed_to is None else f"{one.confirmed_to:.1e}"
        assert row[1:4] == [one.kind, f"{one.uncertainty:.1e}", within]
