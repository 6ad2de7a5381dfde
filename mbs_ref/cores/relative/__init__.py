"""Trees compiled in relative coordinates."""
