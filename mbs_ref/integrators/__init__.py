"""The methods of integration, of the files in methods/."""

import importlib
import pkgutil
from functools import cache
from typing import TYPE_CHECKING

from mbs_ref.integrators import methods

if TYPE_CHECKING:
    from mbs_ref.integrators.loop.leg import Integrator

DEFAULT = "dop853"
SERIES = "taylor"
STIFF = "radau"  # where stability, not accuracy, would make an explicit method's steps short


@cache
def integrators() -> "dict[str, Integrator]":
    """Return every integrator by name, the default first."""
    names = [info.name for info in pkgutil.iter_modules(methods.__path__)]
    every = [x for name in names for x in importlib.import_module(f"{methods.__name__}.{name}").INTEGRATORS]
    return {entry.name: entry for entry in sorted(every, key=lambda entry: (entry.name != DEFAULT, entry.name))}
