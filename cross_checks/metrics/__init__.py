"""The metrics of a run, one file each, listed from this folder; all look at world poses and velocities."""

import importlib
import pkgutil
from functools import cache

from cross_checks.metrics.metric import Metric


@cache
def every() -> dict[str, Metric]:
    """Return every metric by its name, in alphabetical order of their files."""
    modules = [importlib.import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__)]
    listed = [metric for module in modules for metric in getattr(module, "METRICS", ())]
    return {metric.name: metric for metric in listed}
