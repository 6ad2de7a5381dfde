"""mbs-ref proofs: the library's scenes proven, their logs checked, and their truths compared."""

import click

from cross_checks.judge import ladder
from cross_checks.records.store import default_path
from cross_checks.truths import certificate, stored_poses
from mbs_ref import Scene
from mbs_ref.scene.scales import scales_of
from reports import inputs
from reports.commands.judge.certify import every_truth
from reports.commands.judge.prove import LIMIT, RADIUS, bound, need_flint
from reports.console import Failed, echo_json, number, progress, reported_as, show_table

NUMBERS = ("t_end", "reached", "radius", "steps", "prover_s", "checker_s", "log_bytes")
COLUMNS = (*NUMBERS, "distance", "turned", "uncertainty")


@click.command(name="proofs", epilog="Example: mbs-ref proofs double_pendulum")
@click.argument("scene", required=False)
@inputs.PARAMETERS
@inputs.SHARD
@click.option("--seed", type=int, metavar="N", help="Parameters off by at most a tenth, at random.")
@click.option("--again", is_flag=True, help="Check all stored logs instead, at their own radius and times.")
@bound("--radius", 1e-18, RADIUS)
@bound("--limit", 60.0, LIMIT)
@click.option("--write", is_flag=True, help="Store the enclosures of certified scenes: their truths are then proven.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: a list of proofs.")
def command(
    scene: str | None, parameters: tuple[str, ...], shard: str, seed: int | None, radius: float, limit: float,
    again: bool, write: bool, as_json: bool,
) -> None:  # fmt: skip
    """Prove scenes and compare their truths. Without SCENE, all that proofs cover.

    The radius is for scenes up to 1 m; of larger ones it is multiplied by their length in m.
    Logs of complete proofs are stored beside the store of runs, in the folder `proofs`; a scene whose log is there is
    not proven again: its log is checked. Exit code 1 where a truth is outside its enclosure by more than its
    uncertainty, or where a stored log is refused.
    """
    if again and (scene or parameters or seed is not None):
        raise click.UsageError("--again checks every stored log as it is; give it no SCENE, -p or --seed")
    need_flint()
    from cross_checks.truths.proofs.certified import examine, kept, varied
    from cross_checks.truths.proofs.checker.formulas import Refused

    folder = default_path().parent / "proofs"
    with reported_as(Failed, Refused):
        given = [] if again else _covered() if scene is None else [inputs.scene(scene, parameters)]
        built = given if seed is None else [varied(made, seed) for made in given]
        aims = [(made, ladder.grid(made), radius * max(1.0, scales_of(made).length)) for made in built]
        chosen = inputs.shard(kept(folder) if again else aims, shard)
    rows = []
    with progress("prove") as report:
        for done, (made, times, aim) in enumerate(chosen):
            report(done, len(chosen), made.name)
            row, truth = examine(made, times, aim, limit, folder)
            rows.append(row)
            if write and truth and certificate.stored(made) and times.tolist() == ladder.grid(made).tolist():
                stored_poses.save(made, times, truth)
    if as_json:
        echo_json(rows)
    else:
        head = ("scene", "truth", *(key.replace("_", " ") for key in COLUMNS), "not proven because")
        cells = (
            [row["scene"], row["truth"], *(number(row.get(key)) for key in COLUMNS), row["reason"]] for row in rows
        )
        show_table("", head, cells)
    if failed := [f"{row['scene']} ({row['truth']})" for row in rows if row["truth"] in ("outside", "refused")]:
        raise Failed(f"truths outside their enclosures, or refused logs: {', '.join(failed)}")


def _covered() -> list[Scene]:
    """Return the scenes of all certificates, and all others of the library, that proofs cover."""
    from cross_checks.truths.proofs.coverage import complaints

    return [made for made in every_truth() if not list(complaints(made))]
