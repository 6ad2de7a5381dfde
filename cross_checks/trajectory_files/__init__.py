"""Trajectories that other tools wrote: read by a stated map of columns, and held against a truth."""
