"""One compiler decorator, with a disk cache that can never serve stale code.

Numba's cache watches only the file of the compiled function, not the files it calls. Here compiled code is stored
under a digest of every source that it can contain: its module's, and those of all modules which that one imports,
directly or not, from this project or from the folder that its own package lies in. So a change recompiles what it
touches and nothing else, in whatever package the compiled function lies, and checkouts whose sources are equal share
their code.
"""

import hashlib
import importlib.util
import os
import re
import sys
from collections.abc import Callable
from functools import cache, cached_property
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
from numba import types
from numba.core import caching
from numba.core.ccallback import CFunc
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature

_PROJECT = Path(__file__).parents[2]
# Imports in a module's first column: those within functions, or for types alone, reach no compiled code.
_IMPORT = re.compile(r"^(?:from ([\w.]+) import (\([^)]*\)|[^\n]*)|import ([\w., ]+))", re.MULTILINE)


def cache_folder() -> Path:
    """Return where compiled code is stored: under MBS_REF_CACHE, XDG_CACHE_HOME or ~/.cache."""
    root = os.environ.get("MBS_REF_CACHE") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "mbs-ref" / "compiled"


@cache
def source_digest(module: str) -> str:
    """Return a digest of Numba's version and of all sources that compiled code of `module` can contain."""
    digest = hashlib.sha256(numba.__version__.encode())
    for name in sorted(sources_of(module)):
        digest.update(name.encode() + _source(name)[0])
    return digest.hexdigest()[:20]


def sources_of(module: str) -> frozenset[str]:
    """Return the module and every module that compiled code of it can contain."""
    reached, waiting = {module}, [module]
    while waiting:
        new = _source(waiting.pop())[1] - reached
        reached |= new
        waiting.extend(new)
    return frozenset(reached)


@cache
def _source(module: str) -> tuple[bytes, frozenset[str]]:
    """Return a module's source and what it imports of this project and of the packages beside its own."""
    file = _file_of(module)
    if file is None:
        return b"", frozenset()
    content = file.read_bytes()
    home = file.parents[module.count(".") + (file.name == "__init__.py")]  # of the module's top-level package
    found: set[str] = set()
    for parent, names, plain in _IMPORT.findall(content.decode()):
        if plain:
            found |= {name.split(" as ")[0].strip() for name in plain.split(",")}
        else:
            homes = _public(parent)
            found.add(parent)
            for name in re.findall(r"(\w+)(?: as \w+)?", names):
                found.add(homes.get(name, f"{parent}.{name}"))
    return content, frozenset(name for name in found if _lies_in(home, name) or _lies_in(_PROJECT, name))


@cache
def _public(package: str) -> dict[str, str]:
    """Return the module of each public name of a package, as its stub imports them (see `public_names`)."""
    stub = _PROJECT.joinpath(*package.split("."), "__init__.pyi")
    imports = _IMPORT.findall(stub.read_text()) if stub.is_file() else []
    return {name: module for module, names, _ in imports for name in re.findall(r" as (\w+)", names) if module != "."}


@cache
def _lies_in(home: Path, module: str) -> bool:
    path = home.joinpath(*module.split("."))
    return path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()


@cache
def _file_of(module: str) -> Path | None:
    """Return a module's source; None where it has none, as what is typed at a prompt."""
    if module == "__main__":  # a script: it has no spec
        origin = getattr(sys.modules[module], "__file__", None)
    else:
        spec = importlib.util.find_spec(module)
        origin = spec.origin if spec is not None else None
    return Path(origin).absolute() if origin and origin.endswith(".py") else None


class _BySources(caching._CacheLocator):
    """Numba's question where the code of a function is stored, answered by its module's digest."""

    def __init__(self, function: Callable, file: str) -> None:
        self._py_file = file  # where Numba wants to find it
        self._digest = source_digest(function.__module__)
        self._line = function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return str(cache_folder() / self._digest)

    def get_source_stamp(self) -> str:
        return self._digest

    def get_disambiguator(self) -> str:
        return str(self._line)

    @classmethod
    def from_function(cls, py_func: Callable, py_file: str) -> "_BySources":
        return cls(py_func, py_file)


class _Code(caching.CompileResultCacheImpl):
    _locator_classes = [_BySources]


class _Index(caching.IndexDataCacheFile):
    """What is compiled of a function. Another checkout may have compiled it for types that are not known here."""

    def _load_index(self) -> dict[Any, str]:
        try:
            return super()._load_index()
        except (ImportError, AttributeError):
            return {}


class _Cache(caching.FunctionCache):
    """A function's compiled code by its sources, and by the fields and sources of the named tuples that it is given."""

    _impl_class = _Code

    def __init__(self, function: Callable) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _Index(self._cache_path, self._impl.filename_base, stamp)

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        given = getattr(sig, "args", sig)  # a signature, or the types alone
        named: list[Any] = [kind for kind in given if isinstance(kind, types.BaseNamedTuple)]
        layouts = tuple((getattr(kind, "fields", ()), source_digest(kind.instance_class.__module__)) for kind in named)
        return (*super()._index_key(sig, codegen), layouts)


class _Inner(CPUDispatcher):
    """What compiled code calls. Python calls it through a function of one line, which is compiled when it does."""

    @cached_property
    def _entry(self) -> Any:
        function = FunctionType(_enter.__code__, {"inner": self}, self.__name__)
        function.__module__, function.__qualname__ = self.__module__, f"{self.__qualname__}.entry"
        return entry(function)

    def __call__(self, *given: Any) -> Any:
        return self._entry(*given)


def _enter(*given):
    return inner(*given)  # noqa: F821  # pyright: ignore[reportUndefinedVariable]


def _compiler(is_inner: bool = False, **options: Any) -> Callable[[Callable], Any]:
    def compiled(function: Callable) -> Any:
        options["no_cpython_wrapper"] = is_inner
        dispatcher: Any = numba.njit(**options)(function)
        if is_inner:
            dispatcher.__class__ = _Inner
        if _file_of(function.__module__) is not None:
            dispatcher._cache = _Cache(function)
        return dispatcher

    return compiled


# Nobody calls these functions from C, and a wrapper for that would be a tenth of the compile time; one for Python, too.
# Contraction (fused multiply-add) alone is allowed: it keeps NaN, infinities and the order of sums.
_ROUNDING: Any = {"error_model": "numpy", "fastmath": {"contract"}}
_OPTIONS: Any = {**_ROUNDING, "no_cfunc_wrapper": True}
entry = _compiler(**_OPTIONS)  # from Python
jit = _compiler(is_inner=True, **_OPTIONS)
# Of code that makes no arrays: references to those that it is given are not counted, at every line that names one.
bare = _compiler(is_inner=True, _nrt=False, **_OPTIONS)
bare_loop = _compiler(_nrt=False, nogil=True, **_OPTIONS)
placed = _compiler(is_inner=True, forceinline=True, **_OPTIONS)
loop_jit = _compiler(nogil=True, **_OPTIONS)  # of whole runs: other threads go on meanwhile
strict_jit = _compiler()  # every operation is rounded as it is written, and division by zero raises
# For the parts of a loop: called, each would pass a dozen arrays at every step, and count their references.
inlined = numba.njit(inline="always", **_OPTIONS)


@cache
def address_for_c(function: Callable, signature: Any) -> int:
    """Return where C may call a Python function; compile it, or load it from the disk, if need be."""
    callback: Any = CFunc(function, normalize_signature(signature), {}, {"nopython": True, **_ROUNDING})
    callback._cache = _Cache(function)
    callback.compile()
    _kept.append(callback)
    return callback.address


_kept: list[CFunc] = []  # their code lives as long as they do
