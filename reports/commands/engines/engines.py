"""mbs-ref engines: who can simulate what, and environments for those whose packages do not go with ours."""

import re
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path

import click

from cross_checks import engines
from cross_checks.isolation import environments
from cross_checks.judge.capabilities import capabilities, tables
from reports import inputs
from reports.console import Failed, echo_json, reported_as, show_table

EXTRA = re.compile(r"^(?P<what>[^;]+);.*extra == [\"'](?P<extra>[\w-]+)[\"']")
OF_ALL = "engines"  # the extra of the engines that are usual


@click.group(name="engines", invoke_without_command=True, epilog="Example: mbs-ref engines --json")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, with every reason in full.")
@click.pass_context
def command(context: click.Context, as_json: bool) -> None:
    """List the engines, their methods, and what each can model.

    An engine whose packages conflict with those installed here has an environment of its own: `install` creates it.
    """
    if context.invoked_subcommand is not None:
        return
    result = capabilities()
    if as_json:
        echo_json(result)
        return
    for title, head, rows in tables(result):
        show_table(f"\n{title}", head, rows)


@command.command()
@click.argument("name")
@click.option("--into", metavar="FOLDER", type=inputs.FOLDER, help="Folder of the environment.")
@click.option("--over", is_flag=True, help="Use the packages installed here, too: only what differs is installed.")
@click.option(
    "--with", "more", multiple=True, metavar="REQUIREMENT", help="Further requirement that pip installs; repeatable."
)
def install(name: str, into: Path | None, over: bool, more: tuple[str, ...]) -> None:
    """Create an environment of its own for engine NAME, in which it runs from then on.

    An existing environment of NAME is replaced. The file MBS_REF_ENVIRONMENTS lists the environments.
    """
    if name not in engines.names() or name == "mbs_ref":
        allowed = ", ".join(each for each in engines.names() if each != "mbs_ref")
        raise click.UsageError(f"engine = {name!r} is unknown; allowed: {allowed}")
    if into is not None and into.is_dir() and any(into.iterdir()) and not environments.python_of(into).exists():
        raise click.UsageError(f"--into {into} is a folder with other things in it; name an empty one, or none")
    wanted = [*([] if over else [_ourselves()]), *_requirements(name), *more]
    click.echo(f"installing {', '.join(wanted) or 'nothing'}", err=True)
    with reported_as(Failed, environments.NotMade):
        home = environments.make(name, wanted, into, over=over)
    try:
        result = engines.get(name).version()
    except engines.EngineMissing as error:
        environments.forget(name)
        raise Failed(f"{error}; what else it needs can be named by --with") from error
    click.echo(f"{name} {result} lives in {home}")


@command.command()
@click.argument("name")
def forget(name: str) -> None:
    """Run engine NAME from the packages here again; its environment stays where it is."""
    home = environments.forget(name)
    if home is None:
        homes = environments.homes()
        raise click.UsageError(f"{name!r} has no environment of its own; those that have: {', '.join(homes) or 'none'}")
    click.echo(f"{name} is run from here again; its environment {home} may be deleted")


def _ourselves() -> str:
    """Return what pip installs this project from: the tree that runs, else the release of the same version."""
    if (environments.PROJECT / "pyproject.toml").is_file():
        return str(environments.PROJECT)
    return f"mbs-ref=={version('mbs-ref')}"


def _requirements(name: str) -> list[str]:
    """Return what the extra of an engine asks for; of one without an extra of its own, its package among the usual."""
    try:
        extras = metadata("mbs-ref").get_all("Provides-Extra") or []
    except PackageNotFoundError:
        return []
    result = [match for line in requires("mbs-ref") or [] if (match := EXTRA.match(line))]
    wanted = name if name in extras else OF_ALL if engines.is_ours(name) else ""
    return [match["what"].strip() for match in result if match["extra"] == wanted]
