"""Drift of the conserved parts of momentum."""

from mbs_ref.observables import momentum_drift

__all__ = ["momentum_drift"]
