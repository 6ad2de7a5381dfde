"""Families of extremes: each file offers CASES, by the names under which `extremes.toml` describes them."""
