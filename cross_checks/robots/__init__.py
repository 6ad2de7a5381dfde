"""Robot files as scenes, one adapter for each parser, and the comparison of what the parsers read."""
