"""The command line `mbs-ref`, the top of the house. Data go to stdout, progress and complaints to stderr."""

from __future__ import annotations

import importlib
import pkgutil

import click

from mbs_ref.problems import suggest
from reports import commands, exit_codes
from reports.exit_codes import Incomplete


class Commands(click.Group):
    """Find each command by listing its folder; import it only when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(module.name for module in pkgutil.iter_modules(commands.__path__))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        known = self.list_commands(ctx)
        if cmd_name not in known:
            hint = suggest(cmd_name, known)
            raise click.UsageError(f"command {cmd_name!r} is unknown{hint}; the commands are {', '.join(known)}", ctx)
        return importlib.import_module(f"{commands.__name__}.{cmd_name}").command

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Incomplete("interrupted") from None


@click.group(cls=Commands, epilog=exit_codes.TABLE, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="mbs-ref")
def main() -> None:
    """Validate and benchmark solvers of constrained multibody dynamics."""


if __name__ == "__main__":
    main()
