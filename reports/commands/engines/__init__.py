"""Engines and this installation."""
