"""An engine from its adapter file or its name, or a sentence on what is wrong with either."""

import os
import re
from pathlib import Path

from cross_checks import engines
from cross_checks.engine import Engine


class NoEngine(Exception):
    """The adapter cannot be used; the message states what its author must change."""


def name_of(engine: str) -> str:
    """Return the engine's name: of an adapter file <name>_.py, or the name itself."""
    return Path(engine).stem.removesuffix("_") if engine.endswith(".py") else engine


def load(engine: str) -> Engine:
    """Return the engine of an adapter file or of that name. NoEngine says what is wrong; EngineMissing as `get`."""
    if engine.endswith(".py"):
        announce(Path(engine))
    try:
        made = engines.get(name_of(engine))
    except (ValueError, AttributeError, TypeError) as error:
        raise NoEngine(_explained(engine, error)) from error
    if not isinstance(made, Engine):
        raise NoEngine(f"{engine}: ENGINE must be a subclass of cross_checks.engine.Engine, not {type(made).__name__}")
    return _named(made, engine)


def announce(file: Path) -> None:
    """Make the adapter file known to this process and its children."""
    if not file.is_file():
        raise NoEngine(f"{file}: there is no such file")
    listed = [path for path in os.environ.get(engines.ADAPTERS, "").split(os.pathsep) if path]
    if str(file.resolve()) not in listed:
        os.environ[engines.ADAPTERS] = os.pathsep.join([*listed, str(file.resolve())])


def _explained(engine: str, error: Exception) -> str:
    if isinstance(error, AttributeError) and "'ENGINE'" in str(error):
        classes = re.findall(r"^class (\w+)\(.*Engine\)", Path(engine).read_text(), re.MULTILINE)
        return f"{engine} has no line ENGINE = <class>; add ENGINE = {classes[-1] if classes else '<your class>'}"
    if isinstance(error, TypeError):
        return f"{engine}: ENGINE() cannot be made: {error}"
    return str(error)


def _named(made: Engine, engine: str) -> Engine:
    """The file's name is how an engine is called, so the class must say the same."""
    for attribute in ("name", "package", "part_types"):
        if not hasattr(made, attribute):
            raise NoEngine(f"{engine}: {type(made).__name__} has no {attribute}, which every engine declares")
    wanted = name_of(engine)
    if made.name != wanted:
        where = f"rename the file to {made.name}_.py, or set" if engine.endswith(".py") else "set"
        raise NoEngine(f"{engine}: its class is named {made.name!r}; {where} name = {wanted!r}")
    return made
