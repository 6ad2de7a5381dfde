"""The tests any engine must pass, runnable on an adapter that is not part of this project."""
