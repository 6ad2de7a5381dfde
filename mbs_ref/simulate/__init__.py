"""Scenes become trajectories: one run (`simulate`), or many of them in one call."""

from mbs_ref.run.plan import integration_options
from mbs_ref.self_checks.consistent_start import InconsistentScene
from mbs_ref.simulate.batch import simulate_scenes, simulate_starts
from mbs_ref.simulate.one_run import simulate

__all__ = ["InconsistentScene", "integration_options", "simulate", "simulate_scenes", "simulate_starts"]
