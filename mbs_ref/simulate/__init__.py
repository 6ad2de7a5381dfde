"""Scenes become trajectories: one run (`simulate`), or many of them in one call."""

from mbs_ref.simulate.many import simulate_scenes, simulate_starts
from mbs_ref.simulate.one_run import simulate
from mbs_ref.simulate.plan import integration_options
from mbs_ref.simulate.start_checks import InconsistentScene

__all__ = ["InconsistentScene", "integration_options", "simulate", "simulate_scenes", "simulate_starts"]
