"""Many runs of one scene with uncertain inputs, or inputs on a grid: Monte Carlo and parameter sweeps."""

from mbs_ref.simulate.many.ensemble.design import NOTATION, Design, Grid, Law, Normal, Uniform, design, read_law
from mbs_ref.simulate.many.ensemble.runs import Ensemble, run_ensemble
from mbs_ref.simulate.many.ensemble.statistics import (
    Coordinate,
    Statistics,
    account,
    coordinates,
    integration_error,
    not_shown,
    statistics,
    to_dict,
    values_of,
)
from mbs_ref.simulate.many.ensemble.variants import Source, Variants

__all__ = [
    "NOTATION", "Coordinate", "Design", "Ensemble", "Grid", "Law", "Normal", "Source", "Statistics", "Uniform",
    "Variants", "account", "coordinates", "design", "integration_error", "not_shown", "read_law", "run_ensemble",
    "statistics", "to_dict", "values_of",
]  # fmt: skip
