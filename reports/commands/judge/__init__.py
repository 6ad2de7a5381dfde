"""Judge motions and truths."""
