"""The engines: files *_.py and folders *_ here, entry points of the group mbs_ref.engines, and files named on the way.

MBS_REF_ADAPTERS may list adapter files (separated as in PATH) that are neither here nor installed.
"""

import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import redirect_stdout, suppress
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, metadata
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from threading import RLock
from types import ModuleType

from cross_checks.engine import Engine
from cross_checks.isolation.environments import home_of, pins_of, python_of
from cross_checks.isolation.parent import Lost
from mbs_ref.scene.messages import suggest

GROUP = "mbs_ref.engines"
ADAPTERS = "MBS_REF_ADAPTERS"  # an environment variable, so that child processes know the same engines
_IMPORTING = RLock()  # held while an adapter is imported, so that no other thread uses it half imported


class EngineMissing(ImportError):
    """The engine's own package is not installed."""


@cache
def _entry_points() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def _files() -> list[str]:
    """Return the engines whose adapter is a file <engine>_.py, or a package <engine>_ when one file would be long."""
    here = Path(__file__).parent
    files = [*here.glob("*[!_]_.py"), *(path.parent for path in here.glob("*[!_]_/__init__.py"))]
    return sorted(path.stem.removesuffix("_") for path in files)


def _adapters() -> dict[str, Path]:
    """Return the adapter files that the environment names: <engine>_.py or <engine>.py."""
    listed = [Path(text) for text in os.environ.get(ADAPTERS, "").split(os.pathsep) if text]
    return {path.stem.removesuffix("_"): path for path in listed}


def names() -> list[str]:
    """Return every engine's name: the reference first, then the others sorted."""
    known = sorted({*_files(), *_entry_points(), *_adapters()})
    return sorted(known, key=lambda name: name != "mbs_ref")


def installed(chosen: Iterable[str] | None = None) -> Iterator[Engine]:
    """Yield the installed engines among those chosen, or among all."""
    for name in names() if chosen is None else chosen:
        with suppress(EngineMissing):
            yield get(name)


def is_ours(name: str) -> bool:
    """Return whether the engine's adapter is one of this project's."""
    return name in _files()


def called(name: str) -> str:
    """Return what a command line calls the engine: its adapter file where it is known by one, else its name."""
    return str(_adapters().get(name, name))


def get(name: str) -> Engine:
    """Return the named engine.

    ValueError lists what is allowed; EngineMissing says that its own package is absent; any other
    failure to import is a broken adapter and propagates. An engine with an environment of its own runs there.
    """
    home = home_of(name)
    if home is not None and name in names():
        return _elsewhere(name, home)
    if name in _files():
        return _create(f"cross_checks.engines.{name}_", name)
    named = _adapters()
    if name in named:
        return _create_from_file(named[name], name)
    outside = _entry_points()
    if name in outside:
        return _create(outside[name].module, name, outside[name].attr or None)
    raise ValueError(f"engine = {name!r} is unknown{suggest(name, names())}; allowed: {', '.join(names())}")


@cache
def _elsewhere(name: str, home: Path) -> Engine:
    from cross_checks.engines.elsewhere import Elsewhere

    if not python_of(home).exists():
        again = f"mbs-ref engines install {name}"
        raise EngineMissing(f"engine {name!r} has its environment in {home}, which is gone; {again} makes it anew")
    try:
        return Elsewhere(name, home, get)
    except Lost as lost:
        raise EngineMissing(f"engine {name!r} does not start in its environment {home}: {lost}") from lost


def _create_from_file(path: Path, name: str) -> Engine:
    try:
        with _IMPORTING:
            module = sys.modules[_load(path)]
        return getattr(module, "ENGINE")()  # noqa: B009 - the adapter's contract, not an attribute
    except ModuleNotFoundError as error:
        if not _is_of(error.name, _declared_package(path)):
            raise
        raise EngineMissing(f"engine {name!r} needs the package {error.name!r}: {error}", name=error.name) from error


def _load(path: Path) -> str:
    """Import an adapter file under a module name of its own, and return that name."""
    name = f"mbs_ref_adapter_{path.stem}"
    if name not in sys.modules:
        spec = spec_from_file_location(name, path)
        if spec is None or spec.loader is None or not path.is_file():
            raise ValueError(f"{ADAPTERS} names {path}, which is no Python file")
        sys.modules[name] = module = module_from_spec(spec)
        try:
            with redirect_stdout(sys.stderr):
                spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return name


def _create(module_name: str, name: str, attribute: str | None = None) -> Engine:
    """Import the adapter and create its engine: the class an entry point names, else the module's ENGINE."""
    try:
        with _IMPORTING:
            module = sys.modules.get(module_name) or _imported(module_name)
        return getattr(module, attribute or "ENGINE")()
    except ModuleNotFoundError as error:
        if not _is_of(error.name, _package(module_name)):
            raise
        needs = f"engine {name!r} needs the package {error.name!r}"
        raise EngineMissing(f"{needs}{_installation(name)}: {error}", name=error.name) from error


def _imported(module_name: str) -> ModuleType:
    """Import a module; what it prints goes to stderr, for stdout belongs to our answers."""
    with redirect_stdout(sys.stderr):
        return import_module(module_name)


def _is_of(missing: str | None, declared: str | None) -> bool:
    """Return whether the missing module is the declared package, or what that is inside of."""
    return bool(missing and declared) and f"{declared}.".startswith(f"{missing}.")


def _installation(name: str) -> str:
    """Return the command that installs an engine of this project; empty for others, and where metadata are missing.

    An engine with pinned releases is installed in an environment of its own.
    """
    if is_ours(name) and pins_of(name) is not None:
        return f" (mbs-ref engines install {name})"
    try:
        extras = metadata("mbs-ref").get_all("Provides-Extra") or []
    except PackageNotFoundError:
        return ""
    return f" (pip install 'mbs-ref[{name if name in extras else 'engines'}]')" if name in _files() else ""


def _package(module_name: str) -> str | None:
    """Return the `package` an adapter's source declares: read, because importing is what failed."""
    spec = find_spec(module_name)
    if spec is None or spec.origin is None:
        return None
    return _declared_package(Path(spec.origin))


def _declared_package(path: Path) -> str | None:
    declared = re.search(r"^\s+package\b[^=]*=\s*[\"']([\w.]+)[\"']", path.read_text(), re.MULTILINE)
    return declared.group(1) if declared else None
