"""Studies of the full report, a package each: its `measure()` returns what is measured, its study.toml presents it."""
