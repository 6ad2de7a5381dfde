"""The command line `mbs-ref`, the top of the house. Data go to stdout, progress and complaints to stderr."""

from __future__ import annotations

import ast
import importlib
import pkgutil
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import click

from reports import commands
from reports.terminal import console as exit_codes
from reports.terminal.console import Incomplete


class Commands(click.Group):
    """Find each command by listing its folder; import it only when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(_modules())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        known = _modules()
        if cmd_name not in known:
            from mbs_ref.scene.messages import suggest

            hint, listing = suggest(cmd_name, known), ", ".join(sorted(known))
            raise click.UsageError(f"command {cmd_name!r} is unknown{hint}; the commands are {listing}", ctx)
        return importlib.import_module(known[cmd_name]).command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands by their docstrings, read and not imported: that would take a second."""
        room = formatter.width - 6 - max(map(len, _modules()))
        with formatter.section("Commands"):
            listed = [click.Command(name, help=_help_of(_modules()[name])) for name in self.list_commands(ctx)]
            formatter.write_dl([(str(one.name), one.get_short_help_str(room)) for one in listed])

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Incomplete("interrupted") from None


@cache
def _modules() -> dict[str, str]:
    """Return the module of every command by its name; they lie in folders by what they are about."""
    result = pkgutil.walk_packages(commands.__path__, f"{commands.__name__}.")
    return {info.name.rpartition(".")[2]: info.name for info in result if not info.ispkg}


def _help_of(module: str) -> str:
    """Return the docstring of a module's `command`."""
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    parts = ast.parse(Path(spec.origin).read_text(encoding="utf-8")).body
    return next(ast.get_docstring(p) or "" for p in parts if isinstance(p, ast.FunctionDef) and p.name == "command")


@click.group(cls=Commands, epilog=exit_codes.TABLE, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="mbs-ref")
def main() -> None:
    """Validate and benchmark solvers of constrained multibody dynamics."""


if __name__ == "__main__":
    main()
