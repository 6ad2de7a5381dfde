"""Symmetry as a judge: a scene transformed must move as the transformed motion. It needs no truth."""
