"""Trajectories that other tools wrote: read by a stated map of columns, and compared with a truth."""
