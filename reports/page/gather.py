"""Run what the report shows."""


def gather(quick, progress):
    raise NotImplementedError
