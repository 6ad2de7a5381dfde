"""The methods of integration, one file each; a file with an INTEGRATOR is listed here by itself."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from mbs_ref.integrators.leg import Integrator

DEFAULT = "dop853"


@cache
def integrators() -> dict[str, Integrator]:
    """Return every integrator by name, the default first."""
    modules = (importlib.import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__))
    found = [vars(module)["INTEGRATOR"] for module in modules if "INTEGRATOR" in vars(module)]
    return {entry.name: entry for entry in sorted(found, key=lambda entry: (entry.name != DEFAULT, entry.name))}
