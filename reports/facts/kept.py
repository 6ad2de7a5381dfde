"""Facts kept in the store of runs as JSON, by the dataclass that they fill."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from typing import Any

from pydantic import TypeAdapter

from cross_checks import engines
from cross_checks.records.store import Store


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return what turns a dataclass into JSON and back."""
    return TypeAdapter(kind)


def recall[Fact](store: Store, key: str, kind: type[Fact]) -> Fact | None:
    """Return what is kept under a key; None where nothing is."""
    held = store.arrays(key)
    return None if held is None else adapter(kind).validate_python(held[0]["facts"])


def keep[Fact](store: Store, key: str, kind: type[Fact], found: Fact) -> Fact:
    """Keep facts under a key; ValueError where they hold NaN or infinity."""
    plain = adapter(kind).dump_python(found, mode="json")
    json.dumps(plain, allow_nan=False)
    store.keep_arrays(key, {"facts": plain}, {})
    return found


def remembered[Fact](store: Store, key: str, kind: type[Fact], make: Callable[[], Fact]) -> Fact:
    """Return what is kept under a key, else what `make` returns, which is kept."""
    held = recall(store, key, kind)
    return keep(store, key, kind, make()) if held is None else held


@cache
def engine_versions() -> tuple[tuple[str, str], ...]:
    """Return every engine with its version, or why it is missing: facts that several engines make hang on them."""
    return tuple((name, _version(name)) for name in engines.names())


def _version(name: str) -> str:
    try:
        return engines.get(name).version()
    except engines.EngineMissing as error:
        return f"missing: {error}"
