"""Ladders of models, each rung run by the same method: what it costs and what it buys."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from cross_checks.metrics.metric import off_truth
from cross_checks.prices.timing import least_times
from mbs_ref import scenes
from mbs_ref.crash.results import crash_results
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import rolling_slip
from mbs_ref.observables.distance import farthest
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.facts.curves import Measured
from reports.studies.crash import deepest
from reports.studies.models.choice import Ladder, Rung
from reports.studies.sky.measure import observed

Model = tuple[str, Scene, Settings]
# what is shown of a rung, and its accuracy, from its path and that of the last one
Told = Callable[[Scene, Trajectory, Trajectory], tuple[dict[str, float], float | None]]

SKY_LEVELS = ("lumped", "newton", "gr", "j2", "asteroids", "full")
SKY = Settings(method="gauss", rtol=1e-16, samples=2, estimate="off")
ORBIT = Settings(method="dop853", rtol=1e-11, samples=11, estimate="off")
CRASH = Settings(method="dop853", rtol=1e-8, samples=201, estimate="off")
LOOP = Settings(method="dop853", rtol=1e-9, samples=41, estimate="off", reactions=False)
DRIVE = Settings(method="rk4", step=1e-4, t_end=1.6, samples=161, estimate="off")
FORCES = ("zonals", "third_bodies", "drag", "radiation")  # of a satellite, each with those before it


def measure() -> Measured:
    """Run every ladder; a minute with compiled code at hand."""
    return shown([make() for make in dict.fromkeys(FAMILIES.values())])


def shown(ladders: Sequence[Ladder]) -> Measured:
    """Return the ladders as tables."""
    heads = tuple(
        {
            "title": built.title, "note": f"{built.note} {built.method}." if built.method else built.note,
            "cheapest": "; ".join(built.cheapest()) or None,
        }
        for built in ladders
    )  # fmt: skip
    return Measured(tables={"ladders": heads, **{f"ladder: {built.title}": built.rows() for built in ladders}})


def planets() -> Ladder:
    """The solar system with ever more physics, against where the bodies really were."""
    models = [(level, scenes.make("solar_system", model=level, days=200.0), SKY) for level in SKY_LEVELS]
    return ladder(
        "The solar system over 200 days", "Held against DE440.", "significant figures of the least exact body", models,
        lambda scene, *_: ({"bodies": float(len(scene.bodies))}, _figures(scene)),
    )  # fmt: skip


def _figures(scene: Scene) -> float:
    return min(observed(scene, "mbs_ref", SKY).figures.values())


def satellites() -> Ladder:
    """A low satellite for a day with ever more forces, against the last rung."""
    chosen = [("J2", {})] + [(f"and {name}", dict.fromkeys(FORCES[: k + 1], True)) for k, name in enumerate(FORCES)]
    chosen = [("point mass Earth", {"j2": False}), *chosen]
    models = [(name, scenes.make("satellite", **more), ORBIT) for name, more in chosen]

    def text(scene: Scene, path: Trajectory, fullest: Trajectory) -> tuple[dict[str, float], float | None]:
        off = farthest(scene, path, fullest)[0]
        radius = float(np.linalg.norm(scene.bodies[1].position))
        return {"off the fullest model, m": off}, -np.log10(off / radius) if off > 0.0 else None

    note = "A day at 400 km; off is the distance from the last rung, which is no truth."
    return ladder("A satellite's forces", note, "-log10 of off over the orbit's radius", models, text, by_last=True)


def loops() -> Ladder:
    """The same two four-bars on the planar and on the spatial core."""
    models = [(name, scenes.make(name, loops=2), LOOP) for name in ("n_four_bar", "spatial_n_four_bar")]
    return ladder("Planar or spatial bodies", "Two coupled four-bars, the same motion.", ERROR, models, _from_truth)


ERROR = "-log10 of the error over the scene"


def _from_truth(scene: Scene, path: Trajectory, _: Trajectory) -> tuple[dict[str, float], float | None]:
    off = off_truth(scene, path)
    stored = 0.0 if path.step_compliance is None else float(path.step_compliance[:, 1].max())
    shown = {"largest |C|, m": stored}
    return shown, None if off is None else float(-np.log10(max(off[0] / scales_of(scene).length, 1e-16)))


def equations() -> Ladder:
    """A slider-crank by the forms of its equations that the papers weigh."""
    scene = scenes.make("slider_crank")
    forms: tuple[tuple[str, dict[str, Any]], ...] = (
        ("index 1, explicit, constraints closed", {"method": "dop853", "rtol": 1e-6}),
        ("index 1, explicit, drifting", {"method": "dop853", "rtol": 1e-6, "stabilization": "none"}),
        ("index 1, DASSL", {"method": "dassl_index1", "rtol": 1e-6}),
        ("index 2 stabilised, DASSL", {"method": "dassl", "rtol": 1e-6}),
        ("index 3, generalized-alpha", {"method": "generalized_alpha", "step": 1e-3}),
    )
    models = [(name, scene, LOOP.model_copy(update={"rtol": None, **more})) for name, more in forms]
    note = "A slider-crank; one setting each, so that error and time go together."
    return ladder("Form and index of the equations", note, ERROR, models, _from_truth)


def coordinates() -> Ladder:
    """A chain in the bodies' coordinates, with rows, and in its joints'."""
    scene, settings = (
        scenes.make("pendulum_chain", links=10),
        Settings(rtol=1e-9, t_end=1.0, samples=11, estimate="off"),
    )
    chosen = (("bodies' coordinates, with constraint rows", "cartesian"), ("the joints' coordinates", "relative"))
    models = [(name, scene, settings.model_copy(update={"coordinates": kind})) for name, kind in chosen]
    return ladder("Coordinates of a chain", "Ten links, the same motion.", ERROR, models, _from_truth)


def bounces() -> Ladder:
    """A ball on a floor with the force merely clipped by the state, and with its events located."""
    scene = scenes.make("bouncing_ball", law="progressive")
    models: list[Model] = []
    for h in (2e-3, 2e-4):
        step = Settings(method="rk4", step=h, samples=5, estimate="off")
        models += [(f"{words}, h = {h:g} s", scene, step.model_copy(update={"events": events}))
                   for words, events in (("forces clipped", "none"), ("events located", "located"))]  # fmt: skip
    note = "A bounce by the papers' progressive law, RK4."
    return ladder("Events of contact", note, ERROR, models, _from_truth)


def androids() -> Ladder:
    """A front crash from 13 bodies to 48 that touch; what no contact keeps apart passes through."""
    believable = {"stops": True, "body_contacts": True}
    chosen: tuple[tuple[str, str, dict[str, Any]], ...] = (
        ("13 bodies, no belts", "simplified", {"belts": False}),
        ("13 bodies", "simplified", {}),
        ("13 bodies, joint stops", "simplified", {"stops": True}),
        ("13 bodies, stops and contacts", "simplified", believable),
        ("48 bodies", "vertebral", {}),
        ("48 bodies, joint stops", "vertebral", {"stops": True}),
        ("48 bodies, stops and contacts", "vertebral", believable),
    )
    models = [(name, scenes.make(f"android_{kind}", **more), CRASH) for name, kind, more in chosen]

    def text(scene: Scene, path: Trajectory, fullest: Trajectory) -> tuple[dict[str, float], float | None]:
        result = crash_results(scene, path)
        return {
            "HIC36": result.measures["HIC36"], "Nij": result.measures["Nij"],
            "head's travel, m": (travel := float(np.abs(result.head_excursion[:, 0]).max())),
            "passes through, m": max(deepest(scene, path), 0.0),
        }, _digits(travel, float(np.abs(crash_results(models[-1][1], fullest).head_excursion[:, 0]).max()))  # fmt: skip

    note = "From the front, 50 km/h. No truth says which is right: the others are compared with the last rung."
    return ladder("Crash occupants", note, "-log10 of the head's travel, relative", models, text, by_last=True)


def _digits(value: float, reference: float) -> float | None:
    """Return -log10 of how far a value is off, relative; None where it is the reference."""
    off = abs(value - reference) / abs(reference)
    return -np.log10(off) if off > 0.0 else None


def tracks() -> Ladder:
    """A tracked vehicle on flat ground that slides, rolls, is tightened and at rest first, and is sprung."""
    chosen: tuple[tuple[str, dict[str, Any]], ...] = (
        ("the papers' bare one", {"model": "paper"}),
        ("wheels roll", {"preload": 0.0, "start": "drawn"}),
        ("track tightened, from equilibrium", {}),
        ("rollers sprung", {"suspension": True}),
    )
    models = [(name, scenes.make("tracked_vehicle", **more), DRIVE) for name, more in chosen]

    def text(scene: Scene, path: Trajectory, fullest: Trajectory) -> tuple[dict[str, float], float | None]:
        slip = np.abs(rolling_slip(Motion(scene, path), "roller2"))
        hull = scene.body_index("chassis")
        return {
            "way, m": _way(scene, path),
            "slip of a roller, median": float(np.nanmedian(slip)),
            "hull's pitch, degrees": float(np.degrees(np.abs(path.orientation[:, hull]).max())),
        }, _digits(_way(scene, path), _way(models[-1][1], fullest))  # fmt: skip

    note = (
        "1.6 s of driving, the first half second while the torque rises. "
        "No truth says which is right: the others are compared with the last rung."
    )
    return ladder("Tracked vehicle", note, "-log10 of the way, relative", models, text, by_last=True)


def _way(scene: Scene, path: Trajectory) -> float:
    hull = scene.body_index("chassis")
    return float(path.position[-1, hull, 0] - path.position[0, hull, 0])


FAMILIES: dict[str, Callable[[], Ladder]] = {  # by the scenes that they are made of
    "solar_system": planets, "satellite": satellites, "n_four_bar": loops, "spatial_n_four_bar": loops,
    "slider_crank": equations, "pendulum_chain": coordinates, "bouncing_ball": bounces,
    "android_simplified": androids, "android_vertebral": androids, "tracked_vehicle": tracks,
}  # fmt: skip


def ladder(title: str, note: str, measured: str, models: Sequence[Model], text: Told, by_last: bool = False) -> Ladder:
    """Run every model once for what it tells, and in randomly interleaved turns for its time.

    `by_last`: the last model is what the others are held against.
    """
    paths = [_run(title, *model) for model in models]
    again = [partial(_loop_time, scene, settings) for _, scene, settings in models]
    best, rungs = least_times(again, [path.timing.loop_s for path in paths], alone=True), []
    for (name, scene, _), path, seconds in zip(models, paths, best, strict=True):
        shown, accuracy = text(scene, path, paths[-1])
        rungs.append(Rung(name, seconds, int(path.rhs_calls), shown, accuracy))
    reference = models[-1][0] if by_last else ""
    return Ladder(title, note, _method(models[0][2], models), measured, tuple(rungs), reference)


def _run(title: str, name: str, scene: Scene, settings: Settings) -> Trajectory:
    path = simulate(scene, settings)
    if not path.ok:
        raise RuntimeError(f"{title}, {name}: {path.message}")
    return path


def _loop_time(scene: Scene, settings: Settings) -> float:
    return simulate(scene, settings).timing.loop_s


def _method(first: Settings, models: Sequence[Model]) -> str:
    """Return the method and setting that all rungs share; nothing where they differ."""
    if any(settings != first for _, _, settings in models):
        return ""
    return f"{first.method}, " + (f"h = {first.step:g} s" if first.step else f"rtol = {first.rtol:g}")
