"""Equations of motion of mechanisms in the coordinates of their freedoms, each in two formulations."""
