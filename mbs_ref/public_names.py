"""The names that a package offers, imported when they are first used: importing the package takes no time.

They are listed in the package's stub `__init__.pyi`, which type checkers read, too.
"""

import ast
import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Any


def offer(package: str, file: str) -> None:
    """Offer what the stub beside `file` imports as attributes of the package.

    A function may have the name of a subpackage: the subpackage then is callable and calls the function. An unknown
    name raises AttributeError, which lists the public names.
    """
    module = sys.modules[package]
    module.__dict__["_homes"] = _homes(package, Path(file).with_suffix(".pyi"))
    module.__class__ = _Package


def _homes(package: str, stub: Path) -> dict[str, str]:
    """Return the module of each name in the stub; of a subpackage, the package itself."""
    imports = [node for node in ast.parse(stub.read_text()).body if isinstance(node, ast.ImportFrom)]
    return {alias.name: package if node.level else str(node.module) for node in imports for alias in node.names}


class _Package(ModuleType):
    """A package that imports its public names when they are first used."""

    _homes: dict[str, str]

    def __getattr__(self, name: str) -> object:
        if name not in self._homes:
            raise AttributeError(f"{self.__name__} has no {name!r}; public are {', '.join(dir(self))}")
        home = importlib.import_module(self._homes[name])
        value = vars(self).get(name, vars(home).get(name))
        return importlib.import_module(f"{home.__name__}.{name}") if value is None else value

    def __setattr__(self, name: str, value: object) -> None:
        if isinstance(value, ModuleType) and self._homes.get(name, self.__name__) != self.__name__:
            value.__dict__["_home"] = self._homes[name]
            value.__class__ = _Function
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted(self._homes)


class _Function(ModuleType):
    """A subpackage that calls the public function of its own name."""

    _home: str

    def __call__(self, *values: Any, **named: Any) -> Any:
        return getattr(importlib.import_module(self._home), self.__name__.rpartition(".")[2])(*values, **named)
