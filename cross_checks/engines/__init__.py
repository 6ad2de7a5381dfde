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
        return _create(name, f"cross_checks.engines.{name}_")
    if name in (named := _adapters()):
        return _create(name, f"mbs_ref_adapter_{named[name].stem}", named[name])
    if name in (outside := _entry_points()):
        return _create(name, outside[name].module, attribute=outside[name].attr or "ENGINE")
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


def _create(name: str, module: str, path: Path | None = None, attribute: str = "ENGINE") -> Engine:
    """Import an adapter, a file if `path` is given, and create the engine of the class that its attribute names."""
    try:
        with _IMPORTING:
            if module not in sys.modules:
                with redirect_stdout(sys.stderr):  # stdout belongs to our answers
                    _load(module, path) if path else import_module(module)
        return getattr(sys.modules[module], attribute)()
    except ModuleNotFoundError as error:
        declared = _declared_package(module, path)
        if not (error.name and declared and f"{declared}.".startswith(f"{error.name}.")):
            raise
        needs = f"engine {name!r} needs the package {error.name!r}"
        raise EngineMissing(f"{needs}{_installation(name)}: {error}", name=error.name) from error


def _load(name: str, path: Path) -> None:
    """Import an adapter file under a module name of its own."""
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise ValueError(f"{ADAPTERS} names {path}, which is no Python file")
    sys.modules[name] = module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise


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


def _declared_package(module: str, path: Path | None) -> str | None:
    """Return the `package` that an adapter's source declares: read, because importing is what failed."""
    spec = None if path else find_spec(module)
    source = path or (spec and spec.origin)
    pattern = r"^\s+package\b[^=]*=\s*[\"']([\w.]+)[\"']"
    declared = re.search(pattern, Path(source).read_text(), re.MULTILINE) if source else None
    return declared.group(1) if declared else None
