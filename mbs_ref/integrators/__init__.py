"""The methods of integration, of the files in methods/."""

import importlib
import pkgutil
from functools import cache

from mbs_ref.integrators import methods
from mbs_ref.integrators.loop.leg import Integrator

DEFAULT = "dop853"
SERIES = "taylor"
STIFF = "radau"  # where stability, not accuracy, would make an explicit method's steps short


@cache
def integrators() -> dict[str, Integrator]:
    """Return every integrator by name, the default first."""
    modules = [importlib.import_module(f"{methods.__name__}.{x.name}") for x in pkgutil.iter_modules(methods.__path__)]
    every = [item for module in modules for item in vars(module).values() if isinstance(item, Integrator)]
    return {entry.name: entry for entry in sorted(every, key=lambda entry: (entry.name != DEFAULT, entry.name))}
