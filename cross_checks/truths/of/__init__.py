"""The truths by families of systems, found by listing this folder: public functions with the name of their scene."""
