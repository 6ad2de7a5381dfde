"""Parameters of a scene file: `[parameters.NAME]` declares one, `[values]` names what follows from them.

A text that begins with "=" is a formula of both (mbs_ref.scene.base.expression), as in mass = "= density * length", and
formulas in the braces of another text stand for their values, as in name = "rod{k}". A table with `choose` stands for
the one of its entries that the formula names, or for `otherwise`; "none" leaves it out. An item of a list with
repeat = { k = "= rods" } stands for one item for each k = 0, 1, ... below the formula; of several indices the last one
runs fastest, and `values` in the item follow from them. `[requires]` has a sentence for each formula that must be
positive: why others are refused. It may use `[values]` if it stands after them in the file.
"""

import inspect
import re
from collections.abc import Callable, Iterator
from itertools import product
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, TypeAdapter, ValidationError, model_validator

from mbs_ref.scene.base.expression import evaluate
from mbs_ref.scene.base.part import Part, limited

FORMULA = "="  # the mark that a text begins with
CHOOSE, OTHERWISE, NONE = "choose", "otherwise", "none"
REPEAT, VALUES, REQUIRES = "repeat", "values", "requires"
MOST_ITEMS = 1_000_000  # that one index makes
BRACES = re.compile("{(.*?)}")
WHOLE = 1e15  # below, whole numbers are written with all their digits


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
    """Return a value as the names of choices and texts have it."""
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < WHOLE else f"{value:g}"
    return str(value).lower() if isinstance(value, bool) else str(value)


def filled(data: dict[str, Any], given: dict[str, Any], refuse: Callable[[str, str], Exception]) -> dict[str, Any]:
    """Return a scene's data with numbers in place of formulas; raise what `refuse` returns of a place and a mistake."""
    filler = _Filler(given, refuse)
    for key in data:
        if key == REQUIRES:
            filler.require(data, given)
        elif key == VALUES:
            filler.name_values(data, "")
    scene = {key: value for key, value in data.items() if key not in (VALUES, REQUIRES)}
    return filler.fill(scene, "") | {"parameters": given}


class _Filler:
    """Replaces formulas by their values; `known` are the numbers, texts and tables that have a name."""

    def __init__(self, known: dict[str, Any], refuse: Callable[[str, str], Exception]) -> None:
        self.known, self.refuse = dict(known), refuse

    def fill(self, here: Any, place: str) -> Any:
        """Return what stands at a place, with its formulas and choices replaced."""
        if isinstance(here, dict) and CHOOSE in here:
            return self.fill(*self._chosen(here, place))
        if isinstance(here, dict):
            inner = ((key, value, self.fill(value, _at(place, key))) for key, value in here.items())
            return {key: value for key, old, value in inner if value != NONE or old == NONE}
        if isinstance(here, tuple):
            return tuple(value for k, item in enumerate(here) for value in self._items(item, f"{place}[{k}]"))
        if not isinstance(here, str):
            return here
        if here.startswith(FORMULA):
            return self._computed(here.removeprefix(FORMULA), place)
        return BRACES.sub(lambda found: _written(self._computed(found[1], place)), here)

    def name_values(self, here: dict[str, Any], place: str) -> None:
        """Name the `values` of a table."""
        for name, formula in self._table(here, VALUES, place).items():
            self.known[name] = self.fill(formula, _at(_at(place, VALUES), name))

    def require(self, data: dict[str, Any], given: dict[str, Any]) -> None:
        """Raise the sentence of the first requirement that is not positive."""
        for sentence, formula in self._table(data, REQUIRES, "").items():
            place = _at(REQUIRES, sentence)
            value = self.fill(formula, place)
            if not (isinstance(value, int | float) and value > 0.0):
                stated = ", ".join(f"{name} = {value!r}" for name, value in given.items())
                raise self.refuse("parameters", f"{self.fill(sentence, place)}; given: {stated}")

    def _items(self, here: Any, place: str) -> Iterator[Any]:
        """Yield what an item of a list stands for: itself, nothing, or one item for each value of its indices."""
        if not (isinstance(here, dict) and REPEAT in here):
            value = self.fill(here, place)
            yield from (value,) if value != NONE or here == NONE else ()
            return
        counts, outer = self.fill(self._table(here, REPEAT, place), _at(place, REPEAT)), self.known
        for name, count in counts.items():
            if name in outer or not isinstance(count, int | float) or not 0 <= count // 1 == count <= MOST_ITEMS:
                allowed = f"allowed: a name that is new, and a whole number up to {MOST_ITEMS}"
                raise self.refuse(_at(place, REPEAT), f"{name} = {count!r} is no index; {allowed}")
        one = {key: value for key, value in here.items() if key not in (REPEAT, VALUES)}
        for indices in product(*(range(int(count)) for count in counts.values())):
            self.known = outer | dict(zip(counts, indices, strict=True))
            self.name_values(here, place)
            yield from self._items(one, place)
        self.known = outer

    def _chosen(self, here: dict[str, Any], place: str) -> tuple[Any, str]:
        value = self.fill(here[CHOOSE], _at(place, CHOOSE))
        key = _written(value) if _written(value) in here else OTHERWISE
        if key not in here:
            allowed = ", ".join(key for key in here if key != CHOOSE)
            raise self.refuse(place, f"{CHOOSE} = {value!r} names none of its entries; there are {allowed}")
        return here[key], _at(place, key)

    def _computed(self, formula: str, place: str) -> Any:
        try:
            return evaluate(formula, self.known)
        except (ValueError, ArithmeticError, TypeError) as error:
            raise self.refuse(place, str(error.args[-1])) from error

    def _table(self, here: dict[str, Any], name: str, place: str) -> dict[str, Any]:
        if not isinstance(here.get(name, {}), dict):
            raise self.refuse(_at(place, name), "must be a table")
        return here.get(name, {})


def _at(place: str, key: str) -> str:
    return f"{place}.{key}" if place else key
