"""The command line `mbs-ref`, the top of the house. Data go to stdout, progress and complaints to stderr."""

import ast
import errno
import importlib
import os
import pkgutil
import tempfile
import traceback
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import click

from cross_checks.records.record import out_of_memory
from reports import commands
from reports.console import TABLE, Defect, Incomplete

FAULTS = (OSError, MemoryError, ImportError)  # that a command cannot answer for
NEXT = {
    errno.ENOSPC: "free space", errno.EDQUOT: "free space", errno.EMFILE: "allow more open files (ulimit -n)",
    **dict.fromkeys(
        (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR),
        "name a place that can be read and written (by an option, MBS_REF_STORE or XDG_CACHE_HOME)",
    ),
}  # fmt: skip


def fault(error: Exception) -> click.ClickException:
    """Return what the command line prints in place of a traceback, and exits with."""
    if not isinstance(error, FAULTS):
        return _defect(error)
    return Incomplete(" ".join(f"{_sentence(error)}, and repeat the command; what was computed is stored".split()))


def _sentence(error: BaseException) -> str:
    match error:
        case OSError(errno=None):
            return str(error)
        case OSError():
            named = "" if error.filename is None else f"{error.filename}: "
            return f"{named}{error.strerror}: {NEXT.get(error.errno or 0, 'restore what is named')}"
        case ImportError():
            return f"{error}: install the module (`mbs-ref doctor` shows what is missing)"
        case _:
            return out_of_memory(error)


def _defect(error: Exception) -> Defect:
    """Return the line for an error that no input should cause; its traceback is stored."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    file = Path(tempfile.gettempdir(), f"mbs-ref-{os.getpid()}.txt")
    with suppress(OSError):
        file.write_text("".join(traceback.format_exception(error)))
    where = " ".join(f"{type(error).__name__} at {last.filename}:{last.lineno}: {error}".split())
    return Defect(f"this is a defect of mbs-ref; please report it with the command and {file}: {where}")


class Commands(click.Group):
    """List the commands in their folder; a command is imported when it is requested."""

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
        """List the commands by group with their docstrings, read and not imported: that would take a second."""
        room = formatter.width - 6 - max(map(len, _modules()))
        for group in commands.GROUPS:
            package = f"{commands.__name__}.{group}"
            with formatter.section(_docstring(package).rstrip(".")):
                known = {name: module for name, module in _modules().items() if module.startswith(f"{package}.")}
                listed = [click.Command(name, help=_docstring(module, "command")) for name, module in known.items()]
                formatter.write_dl([(str(one.name), one.get_short_help_str(room)) for one in listed])

    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Incomplete("interrupted") from None
        except (click.ClickException, click.Abort, click.exceptions.Exit, BrokenPipeError):
            raise  # as click expects; BrokenPipeError: the reader of the output has ended
        except Exception as error:
            raise fault(error) from error


@cache
def _modules() -> dict[str, str]:
    """Return the module of every command by its name; they lie in folders by what they are about."""
    result = pkgutil.walk_packages(commands.__path__, f"{commands.__name__}.")
    return {info.name.rpartition(".")[2]: info.name for info in result if not info.ispkg}


def _docstring(module: str, function: str = "") -> str:
    """Return the docstring of a module, or of its function."""
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    tree = ast.parse(Path(spec.origin).read_text(encoding="utf-8"))
    parts = [part for part in tree.body if isinstance(part, ast.FunctionDef) and part.name == function]
    return ast.get_docstring(parts[0] if parts else tree) or ""


@click.group(cls=Commands, epilog=TABLE, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="mbs-ref")
def main() -> None:
    """Validate and benchmark solvers of constrained multibody dynamics. `mbs-ref COMMAND --help` shows an example."""


if __name__ == "__main__":
    main()
