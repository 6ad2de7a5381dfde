"""mbs-ref certify: make the truths again and hold them to their certificates."""

from dataclasses import asdict
from typing import Any

import click

from cross_checks.judge.certify import certify, store_poses
from cross_checks.truths import certificate, known
from cross_checks.truths.certificate import Certificate
from cross_checks.truths.truth import NoTruth
from mbs_ref import Scene, scenes
from reports import inputs
from reports.console import Failed, NothingSelected, answer, number, progress, show_table


@click.command(name="certify", epilog="Example: mbs-ref certify pendulum_chain -p links=10")
@click.argument("scene", required=False)
@inputs.PARAMETERS
@click.option("--write", is_flag=True, help="Write the new certificates in place of the stored ones.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: a list of truths.")
def command(scene: str | None, parameters: tuple[str, ...], write: bool, as_json: bool) -> None:
    """Recompute truths and compare them with certificates. Without SCENE, those of all certificates.

    Exit code 1 where they differ by more than their uncertainties.
    """
    chosen = every_truth() if scene is None else [inputs.scene(scene, parameters)]
    rows = []
    with progress("certify") as report:
        for done, built in enumerate(chosen):
            report(done, len(chosen), built.name)
            rows.append(_examined(built, write))
    answer(rows, None, as_json, _show)
    if all(row["verdict"] == "no truth" for row in rows):
        raise NothingSelected("no truth is known of the scenes requested")
    departed = [row["file"] for row in rows if row["verdict"] == "departs"]
    if departed:
        raise Failed(f"truths depart from their certificates: {', '.join(departed)}")


def every_truth() -> list[Scene]:
    """Return the scenes of all certificates, and all others with a truth, with their default parameters."""
    certified = [scenes.make(result.scene, **result.parameters) for result in certificate.every()]
    plain = [scenes.make(name) for name in known() if name in scenes.names()]
    return list({certificate.file_name(scene): scene for scene in (*certified, *plain)}.values())


def _examined(scene: Scene, write: bool) -> dict[str, Any]:
    if write:
        store_poses(scene)
    fresh, before = certify(scene, confirm=write), certificate.stored(scene)
    row: dict[str, Any] = {"file": certificate.file_name(scene)}
    if isinstance(fresh, NoTruth):
        return row | {"verdict": "no truth", "reason": fresh.reason}
    row |= asdict(fresh) | {"decimals": fresh.decimals} | _verdict(before, fresh)
    if write:
        certificate.write(fresh)
    return row


def _verdict(before: Certificate | None, fresh: Certificate) -> dict[str, Any]:
    if before is None:
        return {"verdict": "new", "departs_by": None}
    word = "holds" if certificate.holds(before, fresh) else "departs"
    return {"verdict": word, "departs_by": certificate.departure(before, fresh)}


def _show(rows: list[dict[str, Any]]) -> None:
    lengths = ("known to, m", "two ways, m", "departs by, m")
    shown = []
    for row in rows:
        figures = (number(row.get(key)) for key in ("uncertainty", "difference", "departs_by"))
        known = (f"no truth: {row['reason']}",) if "reason" in row else (row["verdict"], row["kind"], *figures)
        shown.append((row["file"].removesuffix(".json"), *known))
    show_table("", ("truth", "verdict", "kind", *lengths), shown)
