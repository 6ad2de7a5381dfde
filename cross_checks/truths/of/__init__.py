"""The truths by families of systems, found by listing this folder: each file lists its own in TRUTHS."""
