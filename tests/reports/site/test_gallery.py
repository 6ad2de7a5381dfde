"""Tables of the site: what engines take, how well truths are known, from made-up capabilities and the certificates."""

from __future__ import annotations

import random
import re

import pytest

from cross_checks.engine.method import Method
from cross_checks.judge.capabilities import Capability
from cross_checks.truths import certificate
from mbs_ref.scene.traits import PART_TYPES
from reports.site import __main__ as site
from reports.site import gallery


def rows_of(text: str) -> list[list[str]]:
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]


@pytest.fixture
def pages(monkeypatch, tmp_path):
    """Return what returns the pages of a site without a gallery, given what engines can."""

    def written(*able: Capability) -> dict[str, str]:
        monkeypatch.setattr(site, "capabilities", lambda: able)
        site.write_sources(tmp_path / "site", lambda text: None, ())
        return {page.stem: page.read_text(encoding="utf-8") for page in (tmp_path / "site").glob("*.md")}

    return written


@pytest.mark.parametrize("seed", range(2))
def test_what_each_engine_can(pages, seed):
    chance, scenes, able = random.Random(seed), ("andrews", "kepler", "pendulum"), []
    for name in ("zeta", "alpha"):
        parts = {kind: chance.random() < 0.5 for kind in PART_TYPES}
        runs = {scene: (f"why {name} {scene}",) * chance.randint(0, 1) for scene in scenes}
        methods = tuple(Method(f"{name}{k}", "fixed", chance.choice((None, k + 1)), f"of {name}{k}") for k in range(3))
        able.append(Capability(name, True, "", f"{name} 1", methods, parts, runs))
    gone = Capability("gone", False, "needs | a package")
    rows = rows_of(pages(able[0], gone, able[1])["capabilities"])

    def listed(one: Capability) -> list[list[str]]:
        heads = [[one.engine, one.version], *[["", ""]] * (len(one.methods) - 1)]
        return [[*head, m.name, m.kind, str(m.order or "varies"), m.description]
                for head, m in zip(heads, one.methods, strict=True)]  # fmt: skip

    assert rows == [
        ["engine", "version", "method", "kind", "order", "about"], ["---"] * 6,
        *listed(able[0]), ["gone", "missing", "", "", "", "needs | a package"], *listed(able[1]),
        ["part", "zeta", "alpha"], ["---"] * 3,
        *([kind, *("yes" if one.parts[kind] else "not yet" for one in able)] for kind in PART_TYPES),
        ["scene", "zeta", "alpha"], ["---"] * 3,
        *([scene, *("".join(one.scenes[scene]) or "runs" for one in able)] for scene in scenes),
    ]  # fmt: skip
    for scene in (*scenes, "unknown"):
        assert gallery.who_can(scene, (*able, gone)) == ", ".join(
            one.engine for one in able if one.scenes.get(scene) == ())  # fmt: skip


def test_how_well_truths_are_known(pages):
    rows = rows_of(pages()["truths"])
    assert rows[:2] == [["scene", "kind", "known to, m", "our solver within, m", "how"], ["---"] * 5]
    stored = certificate.every()
    assert len(rows) == len(stored) + 2 > 10
    for row, one in zip(rows[2:], stored, strict=True):
        assert row[0].split()[0] == f"`{one.scene}`"
        assert row[0].split()[1:] == [f"{key}={value}" for key, value in one.parameters.items()]
        within = "-" if one.confirmed_to is None else f"{one.confirmed_to:.1e}"
        assert row[1:] == [one.kind, f"{one.uncertainty:.1e}", within, one.how]
