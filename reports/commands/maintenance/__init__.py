"""Maintenance of the project."""
