"""Studies of the full report, a folder each: measure.py returns what is measured, study.toml presents it."""
