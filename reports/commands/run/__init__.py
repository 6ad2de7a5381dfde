"""Run scenes."""
