"""The command line `mbs-ref`, the top of the house. Data go to stdout, progress and complaints to stderr."""

from __future__ import annotations

import importlib
import pkgutil

import click

from mbs_ref.scene.messages import suggest
from reports import commands
from reports.terminal import exit_codes
from reports.terminal.exit_codes import Incomplete


class Commands(click.Group):
    """Find each command by listing its folder; import it only when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted(_modules())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        known = _modules()
        if cmd_name not in known:
            hint, listing = suggest(cmd_name, known), ", ".join(sorted(known))
            raise click.UsageError(f"command {cmd_name!r} is unknown{hint}; the commands are {listing}", ctx)
        return importlib.import_module(known[cmd_name]).command

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Incomplete("interrupted") from None


def _modules() -> dict[str, str]:
    """Return the module of every command by its name; they lie in folders by what they are about."""
    found = pkgutil.walk_packages(commands.__path__, f"{commands.__name__}.")
    return {info.name.rpartition(".")[2]: info.name for info in found if not info.ispkg}


@click.group(cls=Commands, epilog=exit_codes.TABLE, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="mbs-ref")
def main() -> None:
    """Validate and benchmark solvers of constrained multibody dynamics."""


if __name__ == "__main__":
    main()
