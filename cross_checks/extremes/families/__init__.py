"""Families of extremes: each file offers EXTREMES, and is found by listing this folder."""
