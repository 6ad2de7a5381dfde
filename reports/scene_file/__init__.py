"""Scene files: their JSON Schema from the classes of the parts, and the page docs/scene-file.md from the schema.

The description of a field is the comment beside it in its class, its unit first.
"""

import inspect
import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import PydanticOmit

from mbs_ref import Scene
from mbs_ref.files import package_data
from mbs_ref.scene.base.part import Role, fields_of
from mbs_ref.scene.parameters import CHOOSE, FORMULA, REPEAT, Declared

DIALECT = "https://json-schema.org/draft/2020-12/schema"
COMMENTED = re.compile(r"^    (\w+): .*?  # (.+)$", re.MULTILINE)
OF_PYTHON = "function"  # a field that a file cannot hold
WORDS = Path(__file__).with_name("words.md")
PARTS = "<!-- parts -->\n"  # the place of the parts in the words
LISTS = dict(bodies="Bodies", joints="Joints and drives", loads="Loads", contacts="Contacts", events="Events")
NESTED = {"law": ("contacts", "Laws of contact"), "friction": ("contacts", "Friction"), "factor": ("loads", "Signals")}
PLURAL = re.compile(r"^(number|list)\b")
BOUNDS = {"exclusiveMinimum": "> {:g}", "minimum": "≥ {:g}", "exclusiveMaximum": "< {:g}", "maximum": "≤ {:g}"}


FORMULA_TEXT = {"type": "string", "pattern": f"^{FORMULA}|{{.*}}"}
CHOICE = {"type": "object", "properties": {CHOOSE: FORMULA_TEXT}, "required": [CHOOSE], "additionalProperties": True}
REPEATED = CHOICE | {"properties": {REPEAT: {"type": "object"}}, "required": [REPEAT]}


class _Schema(GenerateJsonSchema):
    """A file has no null and no Python: what is absent has its default."""

    def nullable_schema(self, schema: Any) -> dict[str, Any]:
        return self.generate_inner(schema["schema"])

    def callable_schema(self, schema: Any) -> dict[str, Any]:
        return {}

    def model_schema(self, schema: Any) -> dict[str, Any]:
        result, kind = super().model_schema(schema), schema["cls"]
        fields, required = result["properties"], result.get("required", [])
        if OF_PYTHON in required:
            raise PydanticOmit  # from the list of parts, too
        fields.pop(OF_PYTHON, None)
        words = {name: role.value for role in (Role.BODY, Role.END) for name in fields_of(kind, role)}
        for base in kind.__mro__[-3::-1]:  # but object and pydantic's own
            words |= dict(COMMENTED.findall(inspect.getsource(base)))
        for name, field in fields.items():
            field |= {"description": words[name]} if name in words and name != "type" else {}
            fields[name] = {key: value for key, value in field.items() if key != "title" and value is not None}
        if "type" in fields:  # it distinguishes the parts of a list
            result["required"] = ["type", *required]
        return result | {"x-dimensions": list(getattr(kind, "DIMENSIONS", ()))}


@cache
def plain() -> dict[str, Any]:
    """Return the JSON Schema of a scene file without formulas."""
    return {"$schema": DIALECT, **Scene.model_json_schema(schema_generator=_Schema)}


@cache
def schema() -> dict[str, Any]:
    """Return the JSON Schema of a scene file: formulas, choices and repetitions stand for numbers, words and tables."""
    result = _with_formulas(plain())
    parameter = Declared.model_json_schema(schema_generator=_Schema)
    result["properties"]["parameters"]["additionalProperties"]["anyOf"].append(parameter)
    value = {"anyOf": [{"type": "number"}, FORMULA_TEXT, {"type": "object"}]}
    for name in ("values", "requires"):
        result["properties"][name] = {"type": "object", "additionalProperties": value}
    return result


def _with_formulas(rule: Any) -> Any:
    if isinstance(rule, list):
        return [_with_formulas(one) for one in rule]
    if not isinstance(rule, dict):
        return rule
    if rule.get("type") in ("number", "integer") or not rule.keys().isdisjoint(("enum", "pattern", "oneOf")):
        known = {key: rule[key] for key in ("description", "default") if key in rule}
        return {"anyOf": [rule, FORMULA_TEXT, CHOICE, REPEATED]} | known
    return {key: _with_formulas(value) for key, value in rule.items()}


def page() -> str:
    """Return the page in Markdown."""
    head, _, glossary = WORDS.read_text(encoding="utf-8").partition(PARTS)
    return "".join([head, "\n".join(_sections()), "\n", glossary])


def _sections() -> Iterator[str]:
    yield "## The file\n"
    yield from _fields(plain())
    for name, title in LISTS.items():
        yield from _parts(title, f"`[[{name}]]`", kinds(plain()["properties"][name]["items"]), name)
    for field, (within, title) in NESTED.items():
        kind = next(kind for kind in kinds(plain()["properties"][within]["items"]) if field in kind["properties"])
        yield from _parts(title, f"a table, such as `{field}`", kinds(kind["properties"][field]), field)


@cache
def examples() -> dict[str, dict[str, dict[str, Any]]]:
    """Return the fields of an example of each kind of part, by list or field and type."""
    return package_data(__name__, "examples.toml")


def kinds(union: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the schema of each kind of part that a list or a field allows."""
    return [plain()["$defs"][one["$ref"].rpartition("/")[2]] for one in union.get("oneOf", [union])]


def kind_of(part: dict[str, Any]) -> str:
    """Return the type by which a file names a kind of part."""
    return part["properties"]["type"]["const"]


def _parts(title: str, where: str, every: list[dict[str, Any]], name: str) -> Iterator[str]:
    yield f"\n## {title}\n\nWritten as {where}.\n"
    for kind in every:
        places = {(2,): " In the plane alone.", (3,): " In space alone."}.get(tuple(kind.get("x-dimensions", ())), "")
        picture = f"![{kind_of(kind)}](images/parts/{kind_of(kind)}.svg)"
        yield f"### {kind_of(kind)}\n\n{picture}\n\n{kind['description']}{places}\n"
        yield from _fields(kind)
        one = {"type": kind_of(kind), **examples()[name][kind_of(kind)]}
        lines = [f"[[{name}]]", *(f"{key} = {_toml(value)}" for key, value in one.items())]
        yield "\n".join(["\n```", *(lines if name in LISTS else [f"{name} = {_toml(one)}"]), "```\n"])


def _toml(value: Any) -> str:
    """Return a value on one line of TOML."""
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_toml(item)}' for key, item in value.items())} }}"
    return json.dumps(value)


def _fields(kind: dict[str, Any]) -> Iterator[str]:
    yield "| field | value | default | unit, meaning |\n|---|---|---|---|"
    for name, field in kind["properties"].items():
        if name != "type":
            default = "required" if name in kind["required"] else _default(field)
            said = field.get("description", "letters, digits and _ . -" if name == "name" else "")
            yield f"| `{name}` | {_value(field)} | {default} | {said.replace('|', chr(92) + '|')} |"


def _default(field: dict[str, Any]) -> str:
    value = field.get("default")
    if value in (None, "", [], {}):
        return "none"
    return f"{value['type']} {value['value']}" if isinstance(value, dict) else json.dumps(value)


def _value(field: dict[str, Any]) -> str:
    """Return in words what a field holds, with its range."""
    if "oneOf" in field or "$ref" in field:
        return "table: " + ", ".join(f"`{kind_of(kind)}`" for kind in kinds(field))
    if "anyOf" in field:
        return " or ".join(_value(one) for one in field["anyOf"])
    if "enum" in field:
        return ", ".join(f"`{value}`" for value in field["enum"])
    if field.get("type") == "array":
        return _array(field)
    words = {"string": "text", "boolean": "`true`, `false`", "object": "table"}.get(field["type"], field["type"])
    bounds = [text.format(field[bound]) for bound, text in BOUNDS.items() if bound in field]
    return f"{words} {', '.join(bounds)}".rstrip()


def _array(field: dict[str, Any]) -> str:
    item = field.get("items") or field["prefixItems"][0]
    if "oneOf" in item or "$ref" in item:
        return "list of tables"
    low, high = field.get("minItems", 0), field.get("maxItems")
    count = f"{low}" if low == high else f"{low} to {high}" if high else f"{low} or more" if low else "any number of"
    return f"list of {count} {PLURAL.sub(r'\1s', _value(item))}"
