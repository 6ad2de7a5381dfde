"""Families of extremes: each file offers CASES, by the names in `extremes.toml`, and perhaps ENGINES that run some."""
