"""One sentence for each error of validation: the place, the value, and the allowed ones."""

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

LONGEST_VALUE = 60  # characters of a refused value, a name or a key that are shown
MAX_PROBLEMS = 100  # reported at once; a file of megabytes may have millions

# Sentences for pydantic's errors. A template may use the error's context, e.g. {gt}.
SENTENCES = {
    "missing": "is missing",
    "finite_number": "must be a finite number",
    "string_pattern_mismatch": "must start with a letter and hold only letters, digits and _ . -",
    "union_tag_invalid": "is no type allowed here; allowed: {allowed}",
    "union_tag_not_found": "needs a type; allowed: {allowed}",
    "union_number": "must be a number, a text, true or false",
    "tuple_type": "must be a list",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
}


@dataclass(frozen=True)
class Problem:
    """One refused value."""

    path: str  # inside the data, e.g. bodies[2].mass; empty for the whole
    part: str  # name of the part it belongs to; empty where it has none
    value: str  # as written, shortened; empty where nothing was written
    message: str

    def __str__(self) -> str:
        part = f" ({self.part})" if self.part else ""
        value = f" = {self.value}" if self.value else ""
        text = f"{self.path}{part}{value}: {self.message}" if self.path else self.message
        # on one line, with what could upset a terminal written as an escape
        return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def suggest(name: str, allowed: Iterable[str]) -> str:
    """Return `; did you mean 'x'?` for the closest allowed name, or nothing."""
    close = difflib.get_close_matches(name, list(allowed), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


def problems(error: ValidationError, model: type[BaseModel], data: Any) -> list[Problem]:
    """Return what is wrong with `data`, which failed to become a `model`, each place once; MAX_PROBLEMS at most."""
    details = error.errors(include_url=False, include_input=False)
    reported = islice((p for detail in details for p in _translate(detail, model, data)), MAX_PROBLEMS)
    once = list({(p.path, p.message): p for p in reported}.values())
    if len(details) > MAX_PROBLEMS:
        once.append(Problem("", "", "", f"and more of {len(details)} mistakes in all"))
    return once


def sentences(error: ValidationError, model: type[BaseModel], data: Any) -> str:
    """Return the problems as one text, a line each."""
    return "\n".join(str(problem) for problem in problems(error, model, data))


def _translate(detail: Any, model: type[BaseModel], data: Any) -> list[Problem]:
    path, part, models, here, is_scalar_union = _locate(detail["loc"], model, data)
    kind, context = detail["type"], dict(detail.get("ctx", {}))
    if kind == "too_short" and isinstance(here, list | tuple) and len(here) != context["actual_length"]:
        return []  # its items are reported already
    if kind == "value_error":  # our own validators: one line each, already sentences
        return [Problem(path, part, "", line) for line in str(context["error"]).splitlines()]
    if kind == "extra_forbidden":
        return [Problem(path, part, "", _unknown_field(detail["loc"][-1], models))]
    if is_scalar_union:
        kind = "union_number"
    if kind == "union_tag_invalid":
        path, here = f"{path}.type", _item(here, "type")
    value = "" if kind in ("missing", "union_tag_not_found") else _shown(here)
    context["allowed"] = ", ".join(_tags(models))
    message = SENTENCES[kind].format(**context) if kind in SENTENCES else _reword(detail["msg"])
    if kind == "union_tag_invalid":
        message += suggest(_shortened(str(context["tag"])), _tags(models))
    return [Problem(path, part, value, message)]


def _locate(loc: tuple[int | str, ...], model: type[BaseModel], data: Any) -> tuple[str, str, list[Any], Any, bool]:
    """Walk to a place: its path without union tags, the part's name, the models allowed, the value.

    The flag marks a place inside a union of plain values, each of whose members reports an error.
    """
    path, part, models, here = "", "", [model], data
    for key in loc:
        if isinstance(key, str) and not isinstance(here, dict | BaseModel | type(None)):
            return path.removeprefix("."), part, models, here, True
        if len(models) > 1 and isinstance(here, dict) and here.get("type") == key and key in _tags(models):
            models = [m for m in models if m.model_fields["type"].default == key]
            continue
        path += f"[{key}]" if isinstance(key, int) else f".{_shortened(key)}"
        fields = [m.model_fields[key] for m in models if key in m.model_fields] if isinstance(key, str) else []
        if fields:
            models = [m for field in fields for m in _models_in(field.annotation)]
        here = _item(here, key)
        if isinstance(here, dict) and isinstance(here.get("name"), str):
            part = _shortened(here["name"])
    return path.removeprefix("."), part, models, here, False


def _item(here: Any, key: int | str) -> Any:
    if isinstance(here, dict):
        return here.get(key)
    return here[key] if isinstance(here, list | tuple) and isinstance(key, int) and key < len(here) else None


def _models_in(annotation: Any) -> list[Any]:
    """Return the models that an annotation such as tuple[Annotated[A | B, ...], ...] mentions."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _models_in(argument)]


def _tags(models: list[Any]) -> list[str]:
    return [m.model_fields["type"].default for m in models if "type" in m.model_fields]


def _unknown_field(name: int | str, models: list[Any]) -> str:
    allowed = list(dict.fromkeys(field for m in models for field in m.model_fields))
    listing = f" (allowed: {', '.join(allowed)})" if allowed else ""
    return f"is no field here{suggest(_shortened(str(name)), allowed)}{listing}"


def _shown(value: Any) -> str:
    return _shortened(repr(list(value) if isinstance(value, tuple) else value))


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST_VALUE else f"{text[: LONGEST_VALUE - 3]}..."


def _reword(message: str) -> str:
    for theirs in ("Input should", "String should", "Tuple should", "List should", "Dictionary should", "Value should"):
        message = message.replace(theirs, "must")
    return message.replace(" after validation", "")
