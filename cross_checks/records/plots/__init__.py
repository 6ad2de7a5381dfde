"""Plots of the pages, one concept a file."""
