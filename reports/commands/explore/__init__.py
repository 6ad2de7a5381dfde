"""Explore where engines fail."""
