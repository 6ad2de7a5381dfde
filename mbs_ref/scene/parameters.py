"""Parameters of a scene file: `[parameters.NAME]` declares one, `[values]` names what follows from them.

A text that begins with "=" is a formula of both (mbs_ref.scene.base.expression), as in mass = "= density * length". A
table with `choose` stands for the one of its entries that the formula names, or for `otherwise`; "none" leaves it out.
`[requires]` has a sentence for each formula of parameters that must be positive: why others are refused. Formulas in
its braces stand for their values.
"""

import inspect
import re
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, TypeAdapter, ValidationError, model_validator

from mbs_ref.scene.base.expression import evaluate
from mbs_ref.scene.base.part import Part, limited

FORMULA = "="  # the mark that a text begins with
CHOOSE, OTHERWISE, NONE = "choose", "otherwise", "none"


class Declared(Part):
    """A parameter that a scene file declares: what it is unless given, and what is allowed."""

    default: float | int | str | bool
    gt: float | None = None  # greater than
    ge: float | None = None  # at least
    lt: float | None = None  # less than
    le: float | None = None  # at most
    among: tuple[float | int | str, ...] = ()  # the only values allowed; any unless given

    @model_validator(mode="after")
    def _check(self) -> Self:
        try:
            TypeAdapter(self.parameter("default").annotation).validate_python(self.default)
        except (ValidationError, TypeError) as error:  # a text has no bounds
            raise ValueError(f"default = {self.default!r} is not within what is allowed") from error
        return self

    def parameter(self, name: str) -> inspect.Parameter:
        """Return it as a parameter of a function, whose annotation holds what is allowed."""
        kind: Any = Literal[self.among] if self.among else type(self.default)
        bounds = {key: getattr(self, key) for key in ("gt", "ge", "lt", "le") if getattr(self, key) is not None}
        if kind is float:
            kind = Annotated[float, Field(**bounds), AfterValidator(limited)]
        elif bounds:
            kind = Annotated[kind, Field(**bounds)]
        return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=self.default, annotation=kind)


def _written(value: Any) -> str:
    """Return a value as the names of choices and sentences have it."""
    return f"{value:g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)


def _left_out(old: Any, value: Any) -> bool:
    """Return whether a choice or a formula stands for nothing."""
    return value == NONE and old != NONE


def filled(data: dict[str, Any], given: dict[str, Any], refuse: Callable[[str, str], Exception]) -> dict[str, Any]:
    """Return a scene's data with numbers in place of formulas; raise what `refuse` returns of a place and a mistake."""

    def fill(here: Any, place: str) -> Any:
        if isinstance(here, dict) and CHOOSE in here:
            return fill(*chosen(here, place))
        if isinstance(here, dict):
            inner = ((key, value, fill(value, f"{place}.{key}".removeprefix("."))) for key, value in here.items())
            return {key: value for key, old, value in inner if not _left_out(old, value)}
        if isinstance(here, tuple):
            pairs = ((value, fill(value, f"{place}[{k}]")) for k, value in enumerate(here))
            return tuple(value for old, value in pairs if not _left_out(old, value))
        if not isinstance(here, str) or not here.startswith(FORMULA):
            return here
        try:
            return evaluate(here.removeprefix(FORMULA), known)
        except (ValueError, ArithmeticError, TypeError) as error:
            raise refuse(place, str(error.args[-1])) from error

    def chosen(here: dict[str, Any], place: str) -> tuple[Any, str]:
        value = fill(here[CHOOSE], f"{place}.{CHOOSE}")
        key = _written(value) if _written(value) in here else OTHERWISE
        if key not in here:
            allowed = ", ".join(key for key in here if key != CHOOSE)
            raise refuse(place, f"{CHOOSE} = {value!r} names none of its entries; there are {allowed}")
        return here[key], f"{place}.{key}"

    def table(name: str) -> dict[str, Any]:
        if not isinstance(data.get(name, {}), dict):
            raise refuse(name, "must be a table")
        return data.get(name, {})

    def reason(sentence: str) -> str:
        return re.sub("{(.*?)}", lambda found: _written(fill(FORMULA + found[1], f"requires.{sentence}")), sentence)

    known = dict(given)
    for sentence, formula in table("requires").items():
        value = fill(formula, f"requires.{sentence}")
        if not (isinstance(value, int | float) and value > 0.0):
            stated = ", ".join(f"{name} = {value!r}" for name, value in given.items())
            raise refuse("parameters", f"{reason(sentence)}; given: {stated}")
    for name, formula in table("values").items():
        known[name] = fill(formula, f"values.{name}")
    scene = {key: value for key, value in data.items() if key not in ("values", "requires")}
    return fill(scene, "") | {"parameters": given}
