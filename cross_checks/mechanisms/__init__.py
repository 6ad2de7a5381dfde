"""Mechanisms drawn at random, and the dense equations that say whether one is sound."""
