"""The reference of scene files is current and complete; its JSON Schema accepts the library and refuses mistakes."""

import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

import mbs_ref.scene as vocabulary
from mbs_ref import scenes
from mbs_ref.scene import celestial, contact, events, signals
from mbs_ref.scene.toml import SceneFileError, dumps, loads
from reports.cli import main
from reports.scene_file import LISTS, NESTED, examples, kind_of, kinds, page, plain, schema

PAGE = Path(__file__).parents[2] / "docs" / "scene-file.md"
UNIT = re.compile(
    r"-|(m|kg|s|N|rad|days)\b|1/s|(unit vector|direction|world|Euler parameters|J2|number of gaps|point masses)\b|"
    r"of what the signal|of t\^0|one for each|of the (wheel|plane)"
)


def problems(value: Any, rule: dict[str, Any], place: str = "") -> list[str]:
    """Return where a value breaks the part of JSON Schema that is used here."""
    if "$ref" in rule:
        rule = schema()["$defs"][rule["$ref"].rpartition("/")[2]] | {k: v for k, v in rule.items() if k != "$ref"}
    for word, needed in (("oneOf", lambda n: n == 1), ("anyOf", lambda n: n >= 1)):
        if word in rule and not needed(sum(not problems(value, one, place) for one in rule[word])):
            return [f"{place}: {word}"]
    kinds_of = {"object": dict, "array": list, "string": str, "boolean": bool, "number": (int, float), "integer": int}
    if "type" in rule and not isinstance(value, kinds_of[rule["type"]]):
        return [f"{place}: {rule['type']}"]
    if value not in rule.get("enum", [value]) or value != rule.get("const", value):
        return [f"{place}: {value}"]
    wrong = []
    if isinstance(value, dict) and "properties" in rule:
        wrong += [f"{place}.{name}: missing" for name in rule.get("required", ()) if name not in value]
        wrong += [f"{place}.{name}: unknown" for name in value if name not in rule["properties"]]
        known = ((name, item) for name, item in value.items() if name in rule["properties"])
        wrong += [one for name, item in known for one in problems(item, rule["properties"][name], f"{place}.{name}")]
    if isinstance(value, list):
        if not rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", len(value)):
            return [f"{place}: {len(value)} items"]
        rules = rule.get("prefixItems") or [rule.get("items", {})] * len(value)
        wrong += [
            one for k, (i, r) in enumerate(zip(value, rules, strict=True)) for one in problems(i, r, f"{place}[{k}]")
        ]
    if isinstance(value, str) and not re.search(rule.get("pattern", ""), value):
        wrong.append(f"{place}: pattern")
    if isinstance(value, int | float) and not isinstance(value, bool):
        if value < rule.get("minimum", -math.inf) or value > rule.get("maximum", math.inf):
            wrong.append(f"{place}: {value}")
        if value <= rule.get("exclusiveMinimum", -math.inf) or value >= rule.get("exclusiveMaximum", math.inf):
            wrong.append(f"{place}: {value}")
    return wrong


def test_the_page_is_what_the_classes_say():
    assert PAGE.read_text(encoding="utf-8") == page(), "run: mbs-ref scenes --reference > docs/scene-file.md"


@pytest.mark.parametrize("name", scenes.names())
def test_every_scene_of_the_library_satisfies_the_schema(name):
    assert problems(tomllib.loads(dumps(scenes.make(name))), schema()) == []


SWING = """
name = "swing"
[[bodies]]
type = "planar"
name = "rod"
mass = 1.0
inertia = 0.1
[[joints]]
type = "revolute"
name = "pin"
body_a = "ground"
body_b = "rod"
point = [0.0, 0.0]
"""


@pytest.mark.parametrize(("right", "wrong"), [
    ("mass = 1.0", "mass = -1.0"), ("mass = 1.0", "mas = 1.0"), ("inertia = 0.1", ""), ('"revolute"', '"hinge"'),
    ("point = [0.0, 0.0]", "point = [0.0]"), ("mass = 1.0", 'mass = "one"'), ('name = "swing"', 'name = "2 swings"'),
])  # fmt: skip
def test_the_schema_refuses_what_a_scene_refuses(right, wrong):
    assert problems(tomllib.loads(SWING), schema()) == []
    changed = SWING.replace(right, wrong, 1)
    assert problems(tomllib.loads(changed), schema())
    with pytest.raises(SceneFileError):
        loads(changed)


def classes() -> dict[str, Any]:
    homes = (vocabulary, celestial, contact, events, signals)
    every = [kind for home in homes for kind in vars(home).values() if hasattr(kind, "model_fields")]
    named = {kind.model_fields["type"].default: kind for kind in every if "type" in kind.model_fields}
    return {name: kind for name, kind in named.items() if isinstance(name, str)}


def test_every_kind_of_part_has_an_example_that_is_valid():
    unions = {name: plain()["properties"][name]["items"] for name in LISTS}
    listed = {name: kinds(union) for name, union in unions.items()}
    for field, (within, _) in NESTED.items():
        listed[field] = kinds(next(k for k in listed[within] if field in k["properties"])["properties"][field])
    for name, every in listed.items():
        assert set(examples()[name]) == {kind_of(kind) for kind in every}
        for kind in every:
            one = {"type": kind_of(kind), **examples()[name][kind_of(kind)]}
            assert problems(one, kind) == []
            classes()[kind_of(kind)].model_validate(one)
    assert set(classes()) - {kind_of(k) for every in listed.values() for k in every} == {"user_force"}


def test_every_kind_of_part_has_a_small_picture():
    pictures = {path.stem: path for path in (PAGE.parent / "images" / "parts").iterdir()}
    assert set(pictures) == set(classes()) - {"user_force"}
    for path in pictures.values():
        assert ElementTree.parse(path).getroot().get("viewBox") == "0 0 160 96"
        assert path.stat().st_size < 5000


def numbers(rule: dict[str, Any]) -> bool:
    item = rule.get("items") or (rule.get("prefixItems") or [{}])[0]
    return rule.get("type") in ("number", "integer") or item.get("type") == "number"


def test_every_number_states_its_unit_first():
    for kind in schema()["$defs"].values():
        for name, field in kind["properties"].items():
            if numbers(field):
                assert UNIT.match(field.get("description", "")), (kind_of(kind), name, field.get("description"))


def test_the_command_prints_the_schema_and_the_page():
    printed = CliRunner().invoke(main, ["scenes", "--schema"])
    assert json.loads(printed.output) == schema()
    assert CliRunner().invoke(main, ["scenes", "--reference"]).output == page()


def test_a_rule_of_the_schema_holds_what_editors_read_and_nothing_empty():
    """No titles that pydantic makes of names, no null; every field that a class comments has its words."""
    parts = plain()["$defs"].values()
    fields = [
        (part["x-dimensions"], name, field) for part in parts for name, field in part.get("properties", {}).items()
    ]
    assert len(fields) > 200
    for _, name, field in fields:
        assert "title" not in field, name
        assert None not in field.values(), name
    assert sum("description" in field for _, _, field in fields) > 150
