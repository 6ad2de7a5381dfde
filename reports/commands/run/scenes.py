"""mbs-ref scenes: what can be simulated."""

from pathlib import Path

import click

from mbs_ref import scenes
from mbs_ref.scene.toml import SceneFileError, write_scene
from reports import inputs
from reports.console import Failed, echo_json, reported_as, show_table


@click.command(name="scenes", epilog="Example: mbs-ref scenes pendulum slider_crank --files scenes")
@click.argument("names", nargs=-1, metavar="[NAME...]")
@click.option("-p", "parameters", multiple=True, metavar="NAME=VALUE", help="A parameter of the one scene to write.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--files", "folder", type=inputs.FOLDER, help="Write the scenes into this folder as TOML files.")
@click.option("--schema", "form", flag_value="schema", help="Print the JSON Schema of scene files, for editors.")
@click.option("--reference", "form", flag_value="page", help="Print the reference of scene files in Markdown.")
def command(
    names: tuple[str, ...], parameters: tuple[str, ...], as_json: bool, folder: Path | None, form: str | None
) -> None:
    """List the scenes, or write them or their schema as files."""
    if form is not None:
        from reports import scene_file

        return echo_json(scene_file.schema()) if form == "schema" else click.echo(scene_file.page(), nl=False)
    with reported_as(click.UsageError, ValueError):
        result = [scenes.describe(name) for name in names or scenes.names()]
    if parameters and not (folder and len(names) == 1):
        raise click.UsageError("-p belongs to --files and the name of one scene")
    if folder is not None:
        _write([info.name for info in result], parameters, folder)
        return
    if as_json:
        echo_json(result)
        return
    rows = ((one.name, " ".join(f"{k}={v}" for k, v in one.parameters.items()), one.summary) for one in result)
    show_table("", ("scene", "parameters (default)", "about"), rows)


def _write(names: list[str], parameters: tuple[str, ...], folder: Path) -> None:
    """Write a file a scene; one that holds a Python function cannot be written, and is named."""
    folder.mkdir(parents=True, exist_ok=True)
    failed = []
    for name in names:
        try:
            write_scene(inputs.scene(name, parameters), folder / f"{name}.toml")
            click.echo(folder / f"{name}.toml")
        except SceneFileError as error:
            failed.append(name)
            click.echo(str(error), err=True)
    if failed:
        raise Failed(f"not written: {', '.join(failed)}")
