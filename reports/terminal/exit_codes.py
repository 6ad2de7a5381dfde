"""What the exit code of `mbs-ref` says. Click's own usage errors are 2 as well."""

from __future__ import annotations

import click


class Failed(click.ClickException):
    """A validation or regression failed."""

    exit_code = 1


class EngineAbsent(click.ClickException):
    """An engine that was asked for by name is not installed."""

    exit_code = 3


class Incomplete(click.ClickException):
    """The work was cut short; what was computed is kept."""

    exit_code = 4


class NothingSelected(click.ClickException):
    """No scene, engine, method or setting fits what was asked."""

    exit_code = 5


TABLE = """\b
Exit codes:
  0  all is well
  1  a validation failed: a run did not succeed, a cell is wrong
  2  usage: unknown name, bad value, bad scene file
  3  an engine that was asked for is not installed
  4  incomplete: interrupted; what was computed is kept
  5  nothing was selected
"""
