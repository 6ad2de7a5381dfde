"""mbs-ref parity: does every reader see the same robot in a file?"""

from pathlib import Path

import click

from cross_checks.robots import RobotError
from cross_checks.robots.parity import Difference, Dynamics, Parity, parity
from reports import inputs
from reports.console import Failed, NothingSelected, answer, number, reported_as, show_table


@click.command(name="parity", epilog="Example: mbs-ref parity ur5.urdf --poses 5")
@click.argument("file", metavar="ROBOT.urdf|MODEL.xml", type=inputs.FILE)
@click.option("--poses", default=5, show_default=True, type=click.IntRange(1), help="Random places and rates.")
@click.option("--seed", default=1, show_default=True, help="Of the random places.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(file: Path, poses: int, seed: int, as_json: bool) -> None:
    """Compare how four parsers read one robot FILE.

    MuJoCo, Pinocchio, Drake and we may differ in mass matrix, gravity or bias forces.
    Before any integrator runs, parsers may see another robot in the same file, and say nothing. Exit code 1 where they
    do.
    """
    with reported_as(click.UsageError, RobotError):
        result = parity(file, poses, seed)
    facts = result._asdict() | {"differences": [one._asdict() for one in result.differences]}
    answer(facts, None, as_json, lambda _: _show(result))
    if len(result.read) < 2:
        raise NothingSelected(f"fewer than two readers read {file}")
    if result.differences:
        raise Failed(f"readers see different robots: {'; '.join(map(_sentence, result.differences))}")


def _show(result: Parity) -> None:
    rows: list[tuple[str, ...]] = []
    for name in result.read:
        apart = result.apart.get(name)
        figures = [number(apart.get(quantity)) for quantity in Dynamics._fields] if apart else ["compared with"]
        rows.append((name, *figures))
    rows += [(name, f"refuses: {why}") for name, why in result.refused.items()]
    show_table("", ("reader", "mass matrix", "gravity", "bias"), rows)
    click.echo(f"{len(result.joints)} joints: {', '.join(result.joints)}. Differences are over the largest entry.")


def _sentence(one: Difference) -> str:
    where = " and ".join(map(repr, one.joints))
    return f"{one.quantity} at {where} is {one.here:.6g} in {one.reader} and {one.there:.6g} in {one.other}"
