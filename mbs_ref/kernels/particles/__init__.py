"""Particles under gravity: eight instants are evaluated side by side, so that processors work on vectors."""
