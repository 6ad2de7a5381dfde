"""The truths by families of systems, listed from this folder: public functions with the name of their scene."""
