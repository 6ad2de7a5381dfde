"""Measured tosses of a cube, each predicted from its free flight and compared with its motion after it.

The data are those of ContactNets (Pfrommer, Halm and Posa, CoRL 2020, arXiv 2009.11193): 570 tosses with measured mass,
inertia, friction and restitution. `tosses_data/` contains 20 of them and their licence.
"""

import itertools
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from cross_checks import engines
from cross_checks.contact.by_figure import motion, run
from cross_checks.contact.request import NOMINAL_SPEED, ContactModel, linear_law
from cross_checks.isolation.workers import Report
from cross_checks.judge.vocabulary import OURS
from cross_checks.truths.of.bouncing import impact
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.scene import SpatialBody
from mbs_ref.scene import contact as laws
from mbs_ref.scene.euler_parameters import conjugate, from_axis_angle, product, rotation_matrices, rotation_vector
from mbs_ref.trajectory import POSES

STORED = Path(__file__).with_name("tosses_data") / "tosses.npz"
COLUMNS = 19  # of the published tensors: position, quaternion, velocity, angular velocity and control
RATE, GRAVITY = 148.0, np.array((0.0, 0.0, -9.81))  # Hz, m/s^2
HALF, MASS, INERTIA, FRICTION, RESTITUTION = 0.0524, 0.37, 0.00081, 0.18, 0.125  # m, kg, kg m^2, -, -: published
CORNERS = HALF * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
CLEAR = 1e-3  # m, ten times the noise of a corner: samples above it are free of the floor
FEWEST = 3  # samples of a free flight
DEPTH = 1e-4  # m, penetration at NOMINAL_SPEED, below the noise: the publication states no stiffness
SEED = 0  # of a sample
RTOL, FINER = 1e-6, 1e-2  # of the reference solver, and the factor on it at each refinement
STEPS = 4  # times as many at each refinement of an engine of fixed steps
RESOLVED, REFINEMENTS = 0.01, 4  # of the error: refinement ends where two runs differ by less, or after these


def corners(position: np.ndarray, orientation: np.ndarray) -> np.ndarray:
    """Return the cube's corners (..., 8, 3), m, from its centre (..., 3) and Euler parameters (..., 4)."""
    return position[..., None, :] + CORNERS @ np.swapaxes(rotation_matrices(orientation), -1, -2)


@dataclass(frozen=True)
class Toss:
    """One measured motion at RATE."""

    name: str
    position: np.ndarray  # (n, 3) m
    orientation: np.ndarray  # (n, 4) Euler parameters

    @cached_property
    def corners(self) -> np.ndarray:
        """The measured corners (n, 8, 3), m."""
        return corners(self.position, self.orientation)

    def free(self, floor: float) -> int:
        """Return the number of samples before the first one near the floor (its height in m)."""
        near = self.corners[..., 2].min(axis=1) < floor + CLEAR
        return int(np.argmax(near)) if near.any() else len(near)

    def flight(self, floor: float) -> Trajectory:
        """Return the free flight, fitted to the samples above the floor (m), at these samples.

        All principal moments are equal, so the cube turns at a constant angular velocity. ValueError where fewer than
        FEWEST samples are free.
        """
        n = self.free(floor)
        if n < FEWEST:
            raise ValueError(f"toss {self.name}: {n} samples of free flight; at least {FEWEST} are needed")
        times, middle = np.arange(n) / RATE, self.orientation[n // 2]
        since = times - times[n // 2]
        fall = 0.5 * GRAVITY * since[:, None] ** 2
        turned = rotation_vector(product(self.orientation[:n], conjugate(middle)))
        (v, x), (w, a) = (np.linalg.lstsq(np.vander(since, 2), y)[0] for y in (self.position[:n] - fall, turned))
        turns = a + w * since[:, None]
        angles = np.linalg.norm(turns, axis=1)
        axes = np.where(angles[:, None] > 0.0, turns, 1.0)  # any axis serves where the angle is 0
        orientation = product(from_axis_angle(axes, angles), middle)
        velocity, spin = v + GRAVITY * since[:, None], np.broadcast_to(w, (n, 3))
        position = x + v * since[:, None] + fall
        return Trajectory(times, position[:, None], orientation[:, None], velocity[:, None], spin[:, None])

    def error(self, path: Trajectory) -> float:
        """Return the root mean square distance (m) of the corners from those of a motion at the first samples."""
        apart = corners(path.position[:, 0], path.orientation[:, 0]) - self.corners[: len(path.times)]
        return float(np.sqrt(np.mean(np.sum(apart**2, axis=-1))))


def stored(folder: Path | None = None) -> list[Toss]:
    """Return the tosses of this package, or of a folder with the published .pt files; ValueError for another file."""
    if folder is None:
        with np.load(STORED) as data:
            parts = np.split(data["rows"].astype(float), data["starts"])
            rows = dict(zip(data["names"].tolist(), parts, strict=True))
    else:
        rows = {file.stem: _published(file) for file in sorted(folder.glob("*.pt"))}
    if not rows:
        raise ValueError(f"{folder}: no file of a toss, named *.pt, is in this folder")
    turns = {name: row[:, 3:7] / np.linalg.norm(row[:, 3:7], axis=1, keepdims=True) for name, row in rows.items()}
    return [Toss(name, row[:, :3], turns[name]) for name, row in rows.items()]


def _published(file: Path) -> np.ndarray:
    """Return the rows (n, COLUMNS) of a PyTorch file of format 1: their number of doubles and they are its last bytes.

    Lengths are in m; the file has them in units of HALF.
    """
    content = file.read_bytes()
    for start in range(len(content) % 8, len(content), 8):
        size = int.from_bytes(content[start : start + 8], "little")
        if size % COLUMNS == 0 and 0 < 8 * size == len(content) - start - 8:
            rows = np.frombuffer(content, "<f8", offset=start + 8).reshape(-1, COLUMNS)
            return rows * np.where(np.isin(np.arange(COLUMNS), (0, 1, 2, 7, 8, 9)), HALF, 1.0)
    raise ValueError(f"{file}: it must end with rows of {COLUMNS} doubles, as ContactNets' files of tosses do")


def floor_of(tosses: list[Toss]) -> float:
    """Return the height (m) of the floor: the median of what lies HALF below the centres at rest."""
    return float(np.median([toss.position[-1, 2] for toss in tosses])) - HALF


def scene_of(toss: Toss, floor: float, law: laws.ContactLaw, friction: Any = None) -> Scene:
    """Return the cube in the first state of its fitted flight above a floor (m) of that law and friction."""
    start = toss.flight(floor)
    first = {name: getattr(start, name)[0, 0].tolist() for name in POSES}
    inertia = (INERTIA, INERTIA, INERTIA, 0.0, 0.0, 0.0)
    cube = SpatialBody.model_validate({"name": "cube", "mass": MASS, "inertia": inertia} | first)
    contacts = tuple(
        laws.SphereOnPlane(
            name=f"corner{k}", body_a="cube", center=tuple(corner.tolist()), radius=0.0, point=(0.0, 0.0, floor),
            normal=(0.0, 0.0, 1.0), law=law, friction=friction,
        )
        for k, corner in enumerate(corners(start.position[0, 0], start.orientation[0, 0]))
    )  # fmt: skip
    duration = (len(toss.position) - 1) / RATE
    return Scene(name=f"toss{toss.name}", duration=duration, gravity=tuple(GRAVITY), bodies=(cube,), contacts=contacts)


def law_of(kind: Any) -> Any:
    """Return the law of that kind with the published restitution and the penetration DEPTH at NOMINAL_SPEED.

    A law that has a restitution as a parameter gets the published one, which is nominal there.
    """

    def scaled(stiffness: float) -> Any:
        if kind is laws.SpringDamperLaw:
            return linear_law(RESTITUTION, stiffness, MASS)
        more = {"restitution": RESTITUTION} if "restitution" in kind.model_fields else {"damping": stiffness * ratio}
        return kind(stiffness=stiffness, **more)

    def excess(logarithm: float) -> float:  # of the rebound, which depends on c v0/k alone
        return impact(kind(stiffness=1.0, damping=math.exp(logarithm)), MASS, NOMINAL_SPEED).restitution - RESTITUTION

    ratio = 0.0
    if kind in (laws.ProgressiveLaw, laws.HuntCrossleyLaw):
        ratio = math.exp(brentq(excess, -12.0, 8.0, xtol=1e-14))  # type: ignore[arg-type]
    unit = scaled(1.0)  # depth goes as k^(-1/(n + 1))
    return scaled((impact(unit, MASS, NOMINAL_SPEED).penetration / DEPTH) ** (unit.numbers().exponent + 1.0))


LAWS = (laws.SpringDamperLaw, laws.ProgressiveLaw, laws.HuntCrossleyLaw, laws.FloresLaw, laws.LankaraniNikraveshLaw)
SMOOTH = laws.RegularisedCoulomb(coefficient=FRICTION, speed=1e-4)  # m/s, below slip speeds in impacts by far


@dataclass(frozen=True)
class Predicted:
    """One toss by one model, or the reason why there is no prediction."""

    toss: str
    engine: str
    model: str
    flight: float  # m, of the measured corners against the fitted flight: the measurement's noise
    error: float | None = None  # m, of the corners against the measured ones, see Toss.error
    numerical: float | None = None  # m, of the corners against those of a run with 1 % of rtol or a quarter of the step
    reason: str = ""


@dataclass(frozen=True)
class _Model:
    """A contact law of one engine, and its run at RATE, refined so often: the motion, or why there is none."""

    engine: str
    name: str
    law: laws.ContactLaw
    friction: Any
    run: Callable[[Scene, int], Trajectory | str]


def predict(
    tosses: list[Toss], others: dict[str, ContactModel], step: float, sample: int = 0, progress: Report | None = None,
    engine: str = "",
) -> Iterator[Predicted]:  # fmt: skip
    """Predict each toss by the reference solver with each law, and by other engines' own contacts from a step (s) on.

    With `engine` by that one alone. A `sample` is drawn at random with a fixed seed; all are predicted if it is 0.
    ValueError names a toss without a free flight, or a sample larger than all.
    """
    if not 0 <= sample <= len(tosses):
        raise ValueError(f"sample = {sample} tosses; allowed: 1 to {len(tosses)}, or 0 for all")
    floor, steps = floor_of(tosses), math.ceil(1.0 / (RATE * step))
    plain, *rest = [law_of(kind) for kind in LAWS]
    sticking = laws.StickSlip(coefficient=FRICTION, stiffness=plain.stiffness, damping=plain.damping)
    rigid = laws.RigidLaw(restitution=RESTITUTION)
    models = [_Model(OURS, law.type, law, SMOOTH, _ours) for law in (plain, *rest)]
    models += [_Model(OURS, f"{plain.type}, stick_slip", plain, sticking, _ours)]
    models += [_Model(OURS, f"{rigid.type}, no friction", rigid, None, _ours)]

    def sampled(model: ContactModel, method: str) -> Callable[[Scene, int], Trajectory | str]:
        return lambda scene, k: run(model, method, scene, 1.0 / (RATE * steps * STEPS**k), _samples(scene))

    models += [_Model(name, method, plain, SMOOTH, sampled(model, method))
               for name, model in others.items() for method in model.compared]  # fmt: skip
    models = [model for model in models if engine in ("", model.engine)]
    if sample:
        tosses = [tosses[k] for k in np.random.default_rng(SEED).permutation(len(tosses))[:sample]]
    noises = [toss.error(toss.flight(floor)) for toss in tosses]
    every = list(itertools.product(zip(tosses, noises, strict=True), models))
    return _each(every, floor, progress or (lambda *_: None))


def _each(every: list, floor: float, progress: Report) -> Iterator[Predicted]:
    for done, ((toss, noise), model) in enumerate(every, 1):
        yield _predicted(toss, noise, floor, model)
        progress(done, len(every), f"toss {toss.name} by {model.engine} {model.name}")


def _predicted(toss: Toss, noise: float, floor: float, model: _Model) -> Predicted:
    scene = scene_of(toss, floor, model.law, model.friction)
    key = (toss.name, model.engine, model.name, noise)
    path, error, numerical = model.run(scene, 0), 0.0, math.inf
    for refined in range(1, REFINEMENTS + 1):
        if isinstance(path, str) or numerical <= RESOLVED * error:
            break
        finer, error = model.run(scene, refined), toss.error(path)
        if isinstance(finer, str):
            path = finer
            break
        numerical = Toss(toss.name, finer.position[:, 0], finer.orientation[:, 0]).error(path)
        path = finer
    return Predicted(*key, reason=path) if isinstance(path, str) else Predicted(*key, error, numerical)


def _ours(scene: Scene, refined: int) -> Trajectory | str:
    rtol, outputs = RTOL * FINER**refined, "dense" if refined else "landed"  # steps differ
    more: dict[str, Any] = {"rtol": rtol, "atol": rtol * HALF, "outputs": outputs}
    settings = Settings(method="dop853", reactions=False, estimate="off", **more)
    return motion(engines.get(OURS), scene, settings, _samples(scene))


def _samples(scene: Scene) -> np.ndarray:
    return np.arange(round(scene.duration * RATE) + 1) / RATE


@dataclass(frozen=True)
class Summary:
    """All tosses by one model."""

    engine: str
    model: str
    tosses: int  # predicted
    failed: int
    error: float | None  # m, median of the corners' errors; a failed toss counts as infinitely wrong here and below
    interval: str  # m, of the median of all tosses with 95 %; empty unless these are six or more at random
    quartiles: str  # m, of the errors
    share: float | None  # -, median of numerical over total error
    flight: float  # m, median noise of the measured corners
    reason: str  # of the first failure


def summaries(predicted: Iterable[Predicted], *, random: bool = False) -> list[Summary]:
    """Return the medians of each model over its tosses; `random` says that they are a random sample of all."""
    groups: dict[tuple[str, str], list[Predicted]] = {}
    for one in predicted:
        groups.setdefault((one.engine, one.model), []).append(one)
    return [_summary(*key, group, random) for key, group in groups.items()]


def _summary(engine: str, model: str, group: list[Predicted], random: bool) -> Summary:
    known = [(one.error, one.numerical) for one in group if one.error is not None and one.numerical is not None]
    noise, failed = float(np.median([one.flight for one in group])), [one.reason for one in group if one.reason]
    if not known:
        return Summary(engine, model, 0, len(failed), None, "", "", None, noise, failed[0])
    errors, numerical = np.array(known).T
    share, why = float(np.median(numerical / errors)), failed[0] if failed else ""
    ranked, n = np.array([*np.sort(errors), *[math.inf] * len(failed)]), len(group)
    middle, rank = float(np.median(ranked)), max(int(0.5 * n - 0.98 * math.sqrt(n)), 1)  # binomial, 95 %
    between, spread = (f"{ranked[k]:.3g} to {ranked[-1 - k]:.3g}" for k in (rank - 1, n // 4))
    error, between = middle if math.isfinite(middle) else None, between if random and n > 5 else ""  # 2/2^5 > 5 %
    return Summary(engine, model, len(known), len(failed), error, between, spread, share, noise, why)
