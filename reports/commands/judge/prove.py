"""mbs-ref prove: proven enclosures of a motion, with a log that a second program checks."""

import math
import time
from functools import reduce
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click
import numpy as np

from reports import inputs
from reports.console import EngineAbsent, Failed, NothingSelected, echo_json, number, progress, show_table

RADIUS = "Largest radius of an enclosure: m, rad, m/s, rad/s."
LIMIT = "Limit of the prover's processor time for a scene, s."


def bound(name: str, default: float, words: str) -> Any:
    """Return an option whose value is positive."""
    return click.option(name, type=inputs.POSITIVE, default=default, show_default=True, help=words)


@click.command(name="prove", epilog="Example: mbs-ref prove double_pendulum --t-end 10 --radius 1e-25 -o double.log.gz")
@click.argument("scene", metavar="SCENE|FILE.toml", required=False)
@inputs.PARAMETERS
@click.option("--t-end", type=float, metavar="T", help="Duration, s; the scene's own unless given.")
@click.option(
    "--samples", type=click.IntRange(2), default=11, show_default=True, help="Output times from 0 to the end."
)
@click.option("--vary", metavar="P=V+-D", help="Enclose all scenes with the parameter P from V - D to V + D.")
@bound("--radius", 1e-15, RADIUS)
@click.option("--inputs", "reading", type=click.Choice(["binary64", "decimal"]), default="binary64", show_default=True,
              help="The scene's numbers as engines run them, or the decimals as written.")  # fmt: skip
@bound("--limit", 600.0, LIMIT)
@click.option("--json", "as_json", is_flag=True, help="Print the enclosures as JSON.")
@click.option("-o", "output", metavar="LOG", help="Write the log of the proof.")
@click.option("--check", "log_file", metavar="LOG", help="Check a log instead; nothing of the prover is trusted.")
def command(
    scene: str | None, parameters: tuple[str, ...], t_end: float | None, samples: int, vary: str | None, radius: float,
    reading: str, limit: float, as_json: bool, output: str | None, log_file: str | None,
) -> None:  # fmt: skip
    """Enclose the motion of SCENE by a proof. It holds places, turns, velocities and spins at all outputs.

    The theorem is about the scene's numbers: each binary64 value, or each decimal, is exact; rates that loops decide
    solve the closures.
    """
    need_flint()
    if (scene is None) == (log_file is None):
        raise click.UsageError("give either a scene or --check LOG")
    if log_file is not None:
        _check(Path(log_file), as_json)
        return
    assert scene is not None
    from cross_checks.truths.proofs.certified import write_log
    from cross_checks.truths.proofs.checker.formulas import Refused
    from cross_checks.truths.proofs.derivation import NotCovered
    from cross_checks.truths.proofs.integrate import prove, prove_family

    made = inputs.scene(scene, parameters)
    end = made.duration if t_end is None else t_end
    if not end > 0.0:
        raise click.UsageError(f"--t-end {end:g}: a proof needs a duration > 0")
    times = np.linspace(0.0, end, samples).tolist()
    name, low, high = ("", 0.0, 0.0) if vary is None else _interval(vary)
    with progress(f"prove {made.name}") as report:

        def reached(t: float, r: float) -> None:
            report(int(1000 * t / end), 1000, f"t = {t:.4g} s, radius {r:.1e}")

        try:
            if vary is None:
                proofs = [prove(made, times, radius, reading, limit, reached)]
            else:
                proofs = prove_family(
                    lambda value: inputs.scene(scene, (*parameters, f"{name}={value!r}")), low, high, times, reading,
                    limit, reached,
                )  # fmt: skip
        except NotCovered as error:
            raise NothingSelected(f"{made.name}: no proof covers it: {error}") from error
        except (Refused, ValueError) as error:
            raise Failed(f"{made.name}: {error}") from error
    files = [f"{output}.{k}" if k else str(output) for k in range(len(proofs) if output else 0)]
    sizes = [write_log(one.log, Path(file)) for one, file in zip(proofs, files, strict=False)]
    enclosures = [_hull(at) for at in zip(*(one.proof.enclosures for one in proofs), strict=False)]
    least, widest = min(proofs, key=lambda one: one.proof.reached), max(one.proof.radius for one in proofs)
    facts = {"parts": len(proofs), "steps": sum(len(one.log["steps"]) for one in proofs), "log_bytes": sum(sizes),
             "seconds": sum(one.log["seconds"] for one in proofs)}  # fmt: skip
    _show(facts, least.proof, reading, times, enclosures, as_json)
    if reason := least.log["reason"]:
        raise Failed(f"not proven beyond t = {least.proof.reached:g} s, radius {least.proof.radius:.1e}: {reason}")
    if vary is None and widest > radius:
        raise Failed(f"proven to radius {widest:.1e}, above the requested {radius:.1e}")


def _interval(text: str) -> tuple[str, float, float]:
    """Return the parameter of --vary and its least and largest value."""
    try:
        name, numbers = text.split("=")
        middle, half = map(float, numbers.split("+-"))
    except ValueError:
        half = math.nan
    if not 0.0 < half < math.inf:
        raise click.UsageError(f"--vary {text}: write it as length=1+-1e-6, a parameter, its value and half its width")
    return name, middle - half, middle + half


def _hull(parts: tuple[Any, ...]) -> Any:
    """Return balls that contain those of all parts."""
    if isinstance(parts[0], list):
        return [_hull(own) for own in zip(*parts, strict=True)]
    return reduce(lambda a, b: a.union(b), parts)


def need_flint() -> None:
    """Raise EngineAbsent unless python-flint is installed."""
    if find_spec("flint") is None:
        raise EngineAbsent("proofs need the package python-flint: pip install 'mbs-ref[proofs]'")


def _check(file: Path, as_json: bool) -> None:
    from cross_checks.truths.proofs.certified import read_log
    from cross_checks.truths.proofs.checker.formulas import Refused
    from cross_checks.truths.proofs.checker.proof import check

    began = time.process_time()
    try:
        log = read_log(file)
        proof = check(log)
    except Refused as error:
        raise Failed(f"{file} is refused: {error}") from error
    facts = {"steps": len(log["steps"]), "energy": "constant" if proof.model.mechanics.conserves else "not compared",
             "seconds": time.process_time() - began}  # fmt: skip
    _show(facts, proof, log["inputs"], log["times"], proof.enclosures, as_json)


def _show(
    facts: dict[str, Any], proof: Any, reading: str, times: list[float], enclosures: list[Any], as_json: bool
) -> None:
    """Print the facts, and the enclosures: all as JSON, those at the last time for a person."""
    scene, radii = proof.model.scene, (float(x.rad()) for at in enclosures for own in at for x in own)
    unique = "not in singular poses of its loops, where others may branch off" if proof.model.is_exhibited else "yes"
    facts = {"scene": scene.name, "inputs": reading, "radius": max(radii, default=0.0),
             "reached": min(proof.reached, times[-1]), "unique": unique, **facts,
             "impacts": [f"{name} at {t.str(25)} s" for name, t in proof.impacts.times]}  # fmt: skip
    if as_json:
        rows = [dict(zip(scene.body_names, _digits(scene, at, 40), strict=True)) for at in enclosures]
        echo_json(facts | {"times": times[: len(rows)], "bodies": rows})
        return
    for name, value in facts.items():
        click.echo(f"{name}: {number(value) if isinstance(value, float) else value}")
    if enclosures:
        heads = "body", "place, turn, velocity, spin: m, rad, m/s, rad/s"
        rows = zip(scene.body_names, map("  ".join, _digits(scene, enclosures[-1], 25)), strict=True)
        show_table(f"at t = {times[len(enclosures) - 1]:g} s", heads, rows)


def _digits(scene: Any, at: list[Any], count: int) -> list[list[str]]:
    """Return the digits of place, turn, velocity and spin that each type of body has."""
    turns: dict[str, tuple[Any, Any]] = {"planar": ([3], [13]), "spatial": (range(4, 8), range(11, 14))}
    n, rows = scene.dimension, []
    for body, own in zip(scene.bodies, at, strict=True):
        turn, spin = turns.get(body.type, ((), ()))
        rows.append([own[k].str(count) for k in (*range(n), *turn, *range(8, 8 + n), *spin)])
    return rows
