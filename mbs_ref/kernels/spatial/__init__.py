"""Compiled equations of rigid bodies in space, in Euler parameters."""
