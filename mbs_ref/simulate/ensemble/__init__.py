"""Many runs of one scene whose inputs are uncertain, or go over a grid: Monte Carlo and parameter sweeps."""

from mbs_ref.simulate.ensemble.account import account
from mbs_ref.simulate.ensemble.design import Design, design
from mbs_ref.simulate.ensemble.laws import NOTATION, Grid, Law, Normal, Uniform, read_law
from mbs_ref.simulate.ensemble.plain import to_dict
from mbs_ref.simulate.ensemble.runs import Ensemble, run_ensemble
from mbs_ref.simulate.ensemble.statistics import (
    Coordinate,
    Statistics,
    coordinates,
    integration_error,
    not_shown,
    statistics,
    values_of,
)
from mbs_ref.simulate.ensemble.variants import Source, Variants

__all__ = [
    "NOTATION", "Coordinate", "Design", "Ensemble", "Grid", "Law", "Normal", "Source", "Statistics", "Uniform",
    "Variants", "account", "coordinates", "design", "integration_error", "not_shown", "read_law", "run_ensemble",
    "statistics", "to_dict", "values_of",
]  # fmt: skip
