"""mbs-ref engines: who can simulate what, and environments for those whose packages do not go with ours."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from pathlib import Path

import click

from cross_checks import engines
from cross_checks.isolation import environments
from cross_checks.judge.capabilities import Capability, capabilities
from mbs_ref.scene.traits import PART_TYPES
from reports import inputs
from reports.terminal.console import Failed, echo_json, show, table

LACKS = re.compile(r"does not implement the part type '?(\w+)")


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
        echo_json([asdict(item) for item in result])
        return
    show(_methods(result))
    show(_parts(result))
    show(_scenes(result))


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
    try:
        home = environments.make(name, wanted, into, over=over)
    except environments.NotMade as error:
        raise Failed(str(error)) from error
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


def _methods(result: Sequence[Capability]):
    listing = table("Engines", "engine", "version", "method", "kind", "order", "about")
    for item in result:
        if not item.installed:
            listing.add_row(item.engine, "missing", "", "", "", item.reason)
        for k, method in enumerate(item.methods):
            head = (item.engine, item.version) if k == 0 else ("", "")
            listing.add_row(*head, method.name, method.kind, str(method.order or "varies"), method.description)
    return listing


def _parts(result: Sequence[Capability]):
    here = [item for item in result if item.installed]
    listing = table("\nParts of a scene", "part", *(item.engine for item in here))
    for kind in PART_TYPES:
        listing.add_row(kind, *("yes" if item.parts[kind] else "not yet" for item in here))
    return listing


def _scenes(result: Sequence[Capability]):
    here = [item for item in result if item.installed]
    listing = table("\nScenes", "scene", *(item.engine for item in here))
    for scene in here[0].scenes if here else ():
        listing.add_row(scene, *(summary(list(item.scenes[scene])) or "runs" for item in here))
    return listing


def summary(reasons: list[str]) -> str:
    """Return the part types that are lacking, and of other reasons the most frequent with its count."""
    lacking = list(dict.fromkeys(result[1] for reason in reasons if (result := LACKS.search(reason))))
    counts = Counter(_kind(reason) for reason in reasons if not LACKS.search(reason))
    text = [f"lacks {', '.join(lacking)}"] if lacking else []
    if not lacking:
        text += [f"{kind} ({count} times)" if count > 1 else kind for kind, count in counts.most_common(1)]
    more = len(counts) - (0 if lacking else 1)
    return "; ".join([*text, f"{more} more" if more == 1 else f"{more} others"] if more > 0 and text else text)


def _kind(reason: str) -> str:
    """Return a reason without the names of its parts: what stands in quotes, and the numbers of names."""
    return re.sub(r"\b([A-Za-z]+)(?:_?\d+)+(?:_\w+)*\b", r"\1…", re.sub(r"'[^']*'", "…", reason))
