"""Publish results and scenes."""
