"""What a person types, turned into scenes, settings and engines; every mistake is a sentence and exit code 2 or 3."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial, reduce
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from typing import Any

import click
from pydantic import ValidationError

from cross_checks import engines
from cross_checks.conformance.loading import NoEngine, load
from cross_checks.engine import Engine
from cross_checks.engine.plan import broken_start
from mbs_ref import Scene, Settings, scenes
from mbs_ref.scene import messages as problems
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.toml import SceneFileError, read_builder
from mbs_ref.simulate.start_checks import fitted_rates
from reports.console import EngineAbsent, NothingSelected, reported_as

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)
NEW_FILE = click.Path(dir_okay=False, path_type=Path)
FOLDER = click.Path(file_okay=False, path_type=Path)


class _Positive(click.ParamType):
    """Finite numbers greater than 0."""

    name = "float"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number = click.FLOAT.convert(value, param, ctx)
        if not (math.isfinite(number) and number > 0):
            self.fail(f"{number} must be a finite number greater than 0", param, ctx)
        return number


POSITIVE = _Positive()
ENGINES = click.option(
    "--engine", "chosen", multiple=True, metavar="E|FILE.py",
    help="Only this engine, by name or by its adapter file; repeatable.",
)  # fmt: skip
SHARD = click.option("--shard", metavar="I/N", default="1/1", help="Only part I of N, for batch systems.")
ROBOTS = (".urdf", ".xml")  # suffixes of their files
SECONDS = {"": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}  # s, in a duration's unit
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "km": 1e3}  # m


def scene(name_or_file: str, parameters: Sequence[str] = (), keep_rates: Sequence[str] = ()) -> Scene:
    """Return the scene of that name, or in that TOML, URDF or MJCF (.xml) file.

    Initial velocities that `keep_rates` names stay, and the others are computed from the joints.
    """
    built = _read(name_or_file, parameters)
    if not keep_rates:
        return built
    with reported_as(click.UsageError, ValueError):
        return fitted_rates(built, keep_rates, Settings().initial_tolerance)


def comparable(name_or_file: str, parameters: Sequence[str] = (), keep_rates: Sequence[str] = ()) -> Scene:
    """Return a scene on which engines can be compared: one whose start its own joints allow."""
    built = scene(name_or_file, parameters, keep_rates)
    if broken := broken_start(built, Settings().initial_tolerance):
        remedy = "repair the scene, or fix some velocities and compute the others (--keep)"
        raise click.UsageError(f"{name_or_file}: {broken}, which engines would repair differently: {remedy}")
    return built


def _read(name_or_file: str, parameters: Sequence[str]) -> Scene:
    if name_or_file.endswith(ROBOTS):
        return _robot(name_or_file, parameters)
    if Path(name_or_file).is_file() and not name_or_file.endswith(".toml"):
        stated = "a scene file ends in .toml, a robot in .urdf, or in .xml where it is MJCF"
        raise click.UsageError(f"{name_or_file}: the suffix decides the format: {stated}")
    try:
        if name_or_file.endswith(".toml"):
            return _of_file(name_or_file, **_parameters(parameters))
        return scenes.make(name_or_file, **_parameters(parameters))
    except ValidationError as error:  # of the scene with these parameters
        raise click.UsageError(problems.sentences(error, Scene, {})) from error
    except (SceneFileError, ValueError) as error:
        raise click.UsageError(str(error)) from error


def _of_file(file: str, /, **parameters: Any) -> Scene:
    return scenes.build(read_builder(file), file, **parameters)


def rebuilder(name_or_file: str, scene: Scene) -> Callable[..., Scene] | None:
    """Return what makes the scene with other parameters; None where it was read from a file that declares none."""
    if name_or_file.endswith(".toml") and signature(read_builder(name_or_file)).parameters:
        return partial(_of_file, name_or_file, **scene.parameters)
    return partial(scenes.make, name_or_file, **scene.parameters) if name_or_file in scenes.names() else None


PARAMETERS = click.option("-p", "parameters", multiple=True, metavar="NAME=VALUE",
                          help="A parameter of the scene; repeatable.")  # fmt: skip
KEEP = click.option("--keep", "keep_rates", multiple=True, metavar="BODY.velocity|BODY.angular_velocity",
                    help="Fix this initial velocity and compute the others from the joints; repeatable.")  # fmt: skip

RUN = (
    click.option("--method", help="Method of integration; by default mbs_ref chooses (auto) and states why."),
    click.option("--step", type=float, metavar="H", help="Step of a fixed-step method, s."),
    click.option("--rtol", type=float, metavar="R", help="Relative tolerance of an adaptive method."),
    click.option("--atol", type=float, metavar="A", help="Absolute tolerance; follows the scene unless given."),
    click.option("--stabilization", metavar="S", help="none, baumgarte or projection."),
    click.option("--coordinates", type=click.Choice(["cartesian", "relative"]), help="Of bodies, or a tree's joints."),
    click.option("--t-end", type=float, metavar="T", help="Duration, s; the scene's own unless given."),
    click.option("--samples", type=int, metavar="N", help="Output times, evenly spaced from 0 to the end."),
    click.option("--outputs", type=click.Choice(["landed", "dense"]), help="End steps there, or interpolate."),
    click.option("--events", type=click.Choice(["located", "none"]), help="Locate contact events, or clip forces."),
    click.option("--estimate", type=click.Choice(["on", "off"]), help="Whether a second run estimates the error; on."),
    click.option(
        "--project-initial", is_flag=True, help="Project inconsistent initial conditions and report by how much."
    ),
    KEEP,
)  # of the settings of a run


def _giver[C: Callable[..., Any]](options: Sequence[Callable[[C], C]]) -> Callable[[C], C]:
    """Return what gives a command these options, the first of which its help shows first."""
    return lambda command: reduce(lambda given, option: option(given), reversed(options), command)


scene_options = _giver((click.argument("scene", metavar="SCENE|FILE.toml"), PARAMETERS, KEEP))
run_options = _giver(RUN)  # the options of a run


def _robot(file: str, parameters: Sequence[str]) -> Scene:
    """Return the scene of a robot, and say on stderr what was assumed."""
    from cross_checks.robots import RobotError, driven, read_start

    path = Path(file)
    if not path.is_file():
        there = sorted(other.name for other in path.parent.glob("*") if other.suffix in ROBOTS)
        listed = f"robots there: {', '.join(there)}" if there else f"no {' or '.join(ROBOTS)} file is there"
        raise click.UsageError(f"{file}: there is no such file{problems.suggest(path.name, there)}; {listed}")
    given = _parameters(parameters)
    start = Path(str(given.pop("start"))) if "start" in given else None
    with reported_as(click.UsageError, RobotError, ValueError):
        wanted, drives = read_start(start) if start is not None else ({}, {})
        robot = _reader(file)(path, wanted | given)
        built = robot.scene if start is None else driven(robot.scene, drives, start)
    for sentence in robot.assumed:
        click.echo(f"{file}: assumed: {sentence}", err=True)
    return built


def _reader(file: str) -> Callable[..., Any]:
    """Return what reads a robot file; its parser is that of an engine, which must be installed."""
    if file.endswith(".urdf"):
        engine("pinocchio")
        from cross_checks.robots.pinocchio_ import read_urdf

        return read_urdf
    engine("mujoco")
    from cross_checks.robots.mujoco_ import read_mjcf

    return read_mjcf


def settings(**chosen: Any) -> Settings:
    """Return the settings that were chosen; None stands for the default."""
    given = {name: value for name, value in chosen.items() if value is not None}
    try:
        return Settings(**given)
    except ValidationError as error:
        raise click.UsageError(problems.sentences(error, Settings, given)) from error


def engine(name_or_file: str) -> Engine:
    """Return the engine of that name, or of that adapter file; its package must be installed."""
    with reported_as(click.UsageError, NoEngine), reported_as(EngineAbsent, engines.EngineMissing):
        return load(name_or_file)


def engine_names(chosen: Sequence[str]) -> list[str]:
    """Return the names of the engines chosen, by name or adapter file; of all that are known where none is."""
    return [engine(one).name for one in chosen] or engines.names()


def method(solver: Engine, name: str | None) -> str:
    """Return the method's name, or the engine's default."""
    try:
        return solver.method(name).name
    except ValueError as error:
        hint = problems.suggest(str(name), [m.name for m in solver.methods()])
        raise click.UsageError(f"{error}{hint}") from error


def seconds(text: str) -> float:
    """Return a duration such as 50ms in seconds."""
    value, unit = _quantity("--budget", text, SECONDS)
    return value * SECONDS[unit]


def relative_error(text: str, scene: Scene) -> float:
    """Return an error over the scene's scales: a bare number as it is, a length such as 1mm over the scene's length."""
    value, unit = _quantity("--error", text, LENGTHS)
    return value * LENGTHS[unit] / scales_of(scene).length if unit else value


def _quantity(option: str, text: str, units: Mapping[str, float]) -> tuple[float, str]:
    """Return a positive number and its unit, which may be left out."""
    match = re.fullmatch(r"\s*([-+0-9.eE]+?)\s*([a-z]*)\s*", text)
    value = _number(match[1]) if match else math.nan
    if not match or match[2] not in ("", *units) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        allowed = f"a positive number, or one with a unit of {', '.join(filter(None, units))}"
        raise click.UsageError(f"{option} {text!r} is not understood; allowed: {allowed}")
    return float(value), match[2]


def shard[T](items: Sequence[T], text: str) -> list[T]:
    """Return part I of N, written as I/N; the parts are disjoint and together everything. NothingSelected if empty."""
    part = re.fullmatch(r"(\d+)/(\d+)", text)
    index, count = (int(part[1]), int(part[2])) if part else (0, 0)
    if not 1 <= index <= count:
        raise click.UsageError(f"shard = {text} must be I/N with 1 <= I <= N")
    if not (chosen := list(items[index - 1 :: count])):
        raise NothingSelected(f"part {text} of {len(items)} is empty")
    return chosen


def output(path: str | None, allowed: tuple[str, ...]) -> Path | None:
    """Return where to write, after looking at all that can be wrong with it before the run."""
    if path is None:
        return None
    target = Path(path)
    if target.suffix not in allowed:
        raise click.UsageError(f"-o {path}: suffix {target.suffix!r} is unknown; allowed: {', '.join(allowed)}")
    if not target.absolute().parent.is_dir():
        raise click.UsageError(f"-o {path}: there is no folder {target.parent}")
    if target.suffix == ".parquet" and not _has_pyarrow():
        raise click.UsageError(f"-o {path}: Parquet needs the package pyarrow: pip install 'mbs-ref[parquet]'")
    return target


def _has_pyarrow() -> bool:
    try:
        return find_spec("pyarrow") is not None
    except ValueError:  # its import is barred
        return False


def _parameters(words: Sequence[str]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not name or not equals:
            raise click.UsageError(f"-p {word}: must be name=value")
        if name in result:
            raise click.UsageError(f"-p {name} is given twice")
        result[name] = _number(value)
    return result


def _number(text: str) -> int | float | bool | str:
    """Read true, false, an integer or a float; anything else stays text."""
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
