"""The androids' crash as the first paper ran it: figures 1 to 5, its methods, and what its sentences add."""

from typing import Any

import numpy as np

from mbs_ref import Settings, Status, Trajectory, scenes
from mbs_ref.crash.outlines import outlines
from mbs_ref.crash.results import crash_results
from mbs_ref.crash.stops import tension
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import PointBushing, Revolute, Scene, SpringDamper, TorsionSpring
from mbs_ref.scene.contact import CircleOnLine
from mbs_ref.simulate import simulate
from reports.facts.curves import Film, Measured, Row, Value, film
from reports.studies.crash import FINE, IMPACTS, PAPER, RAN, deepest, finished, forces, largest_gap, with_test

PICTURES = 9  # 0.025 s apart to 0.2 s
AS_THEY_RAN: dict[str, Any] = {"stabilization": "none", "reactions": False, "estimate": "off", "samples": 201}


def measure_crash() -> Measured:
    """Run both androids from the front, and what the claims name beside what the studies of the crashes measure."""
    built = {kind: scenes.make(f"android_{kind}", **PAPER) for kind in RAN["shown"]}
    paths = {kind: finished(scene) for kind, scene in built.items()}
    results = {kind: crash_results(built[kind], paths[kind]).forces for kind in built}
    figures: dict[str, Value] = {}
    for kind, scene in built.items():
        figures |= _believable(kind)
        for method, more in RAN["methods"][kind].items():
            figures |= method_figures(f"{kind}.{method}", scene, method, more)
    figures |= _touching(built["simplified"], paths["simplified"])
    figures |= _parts(built["vertebral"]) | _rising(built, paths, results)
    figures["vertebral.rk4.refusal"] = simulate(built["vertebral"], Settings(method="rk4", step=1e-4)).message
    figures |= _constraints(built["simplified"]) | _in_space(built["simplified"])
    films = {
        "Fig. 1": _film("simplified", 15_500.0, **PAPER), "Fig. 2": film(built["vertebral"], paths["vertebral"], 5),
        "Fig. 2, joints that stop and parts that touch": _film("vertebral", 15_000.0),
    }  # fmt: skip
    drawn = {}
    for name, one in RAN["figures"].items():
        kind, values = one["android"], getattr(results[one["android"]], one["kind"])
        drawn |= forces(f"{name}, {one['caption']}", built[kind], paths[kind].times, values, RAN["shown"][kind])
    return Measured(figures, {}, drawn, films)


def _touching(scene: Scene, path: Trajectory) -> dict[str, Value]:
    """Return the foot's largest contact forces (N), and how often a force on the seat back starts or ends."""
    motion, pushes = Motion(scene, path), {name: np.hypot(*own[:, 1:3].T) for name, own in path.contacts.items()}
    belts = [tension(motion, load) for load in scene.loads if isinstance(load, SpringDamper)]
    on_back = [*(force for name, force in pushes.items() if name.endswith(".seat_back")), *belts]
    changes = sum(int(np.count_nonzero(np.diff(force > 0.0))) for force in on_back)
    feet = {f"foot.{point}": float(pushes[f"foot.{point}.floor"].max()) for point in ("heel", "ball")}
    return {"seat_back.parts": len(on_back), "seat_back.changes": changes, **feet}


def _parts(scene: Scene) -> dict[str, Value]:
    """Return how many parts of each kind that the paper names the vertebral android has."""
    kinds = {"revolutes": Revolute, "restoring": TorsionSpring, "tissue": PointBushing}
    every = (*scene.joints, *scene.loads)
    return {f"parts.{name}": sum(isinstance(part, kind) for part in every) for name, kind in kinds.items()}


NECK = ("head", "C1", "C2", "C3", "C4", "C5", "C6")


def _rising(scenes_: dict[str, Scene], paths: dict[str, Trajectory], results: dict[str, Any]) -> dict[str, Value]:
    """Return the start, how Q_c rises, how often it is negative along x first, and the belts' largest pull (N)."""
    scene, path = scenes_["simplified"], paths["simplified"]
    held = {kind: own.constraint for kind, own in results.items()}
    sizes = [np.hypot(*held["simplified"][:, scene.body_index(part), :2].T) for part in ("head", "thorax", "lumbar")]
    neck = [held["vertebral"][:, scenes_["vertebral"].body_index(part), 0] for part in NECK]
    motion, pulls = Motion(scene, path), []
    for belt in (load for load in scene.loads if isinstance(load, SpringDamper)):
        apart = motion.point(belt.body_a, belt.point_a)[0] - motion.point(belt.body_b, belt.point_b)[0]
        pulls.append((tension(motion, belt) / np.hypot(*apart.T))[:, None] * apart)
    pull = np.sum(pulls, axis=0)
    pulled = pull[np.argmax(np.hypot(*pull.T))]
    return {
        "start.gap": abs(float(path.contacts["bottom.buttock.seat_base"][0, 0])),
        "start.speed": float(np.abs(path.velocity[0]).max()), "rising.backward": float(pulled[0]),
        "rising.downward": float(pulled[1]), "rising.start": max(float(x[0]) for x in sizes),
        "rising.least": min(float(x.max()) for x in sizes),
        "rising.neck": float(sum(x.min() < 0.0 < x.max() and x.argmin() < x.argmax() for x in neck)),
    }  # fmt: skip


def _in_space(planar: Scene) -> dict[str, Value]:
    """Return what the android in space does: straight, against the planar one, and obliquely."""
    fine = Settings(rtol=1e-12, samples=21, estimate="off", reactions=False)
    flat, straight = (simulate(scene, fine) for scene in (planar, scenes.make("android_spatial", oblique=0.0, **PAPER)))
    path = simulate(scenes.make("android_spatial", **PAPER), fine)
    within = Partial(straight.position[:, :, :2])
    apart = farthest(planar, within, flat)[0] if straight.ok else straight.message
    return {
        "spatial.apart": apart, "spatial.time": straight.timing.loop_s / flat.timing.loop_s,
        "spatial.sideways": float(np.abs(path.position[:, 0, 2]).max()) if path.ok else path.message,
    }  # fmt: skip


def _constraints(scene: Scene) -> dict[str, Value]:
    """Return the work of the crash with every contact force replaced by a constraint (Fox 2001), and without."""
    settings = FINE.model_copy(update={"rtol": 1e-6, "samples": 41})
    one, other = simulate(scene, settings), simulate(scenes.make(scene.name, law="constraint", **PAPER), settings)
    return {
        "contacts.steps": float(one.steps), "constraints.steps": float(other.steps),
        "constraints.status": str(other.status) if other.ok else other.message,
        "constraints.apart": farthest(scene, one, other)[0] if other.ok else "stopped",
    }  # fmt: skip


def _film(kind: str, force: float, **parameters: Any) -> Film:
    scene = scenes.make(f"android_{kind}", peak_force=force, **parameters)
    return film(scene, simulate(scene, FINE.model_copy(update={"samples": 8 * (PICTURES - 1) + 1})), 2)


def _believable(kind: str) -> dict[str, Value]:
    """Return what stops and contacts change, front and rear."""
    figures: dict[str, Value] = {}
    for impact in IMPACTS:
        scene = scenes.make(f"android_{kind}", impact=impact)
        figures[f"{kind}.{impact}.believable_deepest"] = deepest(scene, finished(scene))
    for restraint in ("integral", "separate", "none"):
        scene = scenes.make(f"android_{kind}", impact="rear", head_restraint=restraint)
        result = crash_results(scene, finished(scene))
        figures[f"{kind}.rear.{restraint}.HIC36"] = result.measures["HIC36"]
        figures[f"{kind}.rear.{restraint}.Nij"] = result.measures["Nij"]
        figures[f"{kind}.rear.{restraint}.neck_least"] = float(result.neck_moment.min())
    return figures


def method_figures(name: str, scene: Scene, method: str, more: dict[str, Any]) -> dict[str, Value]:
    """Run a method of the papers under their own test |C| < h, and to the end; the figures begin with the name."""
    settings = Settings(method=method, **more, **AS_THEY_RAN, events="located" if method == "lsodar" else "none")
    path, test, error = with_test(scene, settings)
    ended = "fails" if test.status is Status.COMPLIANCE else "keeps" if test.ok else str(test.status)
    return {
        f"{name}.status": str(path.status), f"{name}.test": ended,
        f"{name}.until": float(test.times[-1]), f"{name}.compliance": largest_gap(path),
        f"{name}.error": path.message if error is None else error,
        f"{name}.switches": float(path.method_switches or 0), f"{name}.steps": float(path.steps),
    }  # fmt: skip


MOMENTS = 8  # 0.025 s apart
ARMS = ("upper_arm", "lower_arm", "hand")
# a shape: time (s), kind (body | arm | seat), both ends and the radius (m)
RUN = Settings(rtol=1e-7, samples=MOMENTS + 1, estimate="off", reactions=False)


def outline_pictures() -> dict[str, tuple[Row, ...]]:
    """Return the crashes in which bare and believable models differ: the lines to draw at each time."""
    drawn = {title: {**given} for title, given in RAN["drawn"].items()}
    built = {title: scenes.make(f"android_{given.pop('android')}", **given) for title, given in drawn.items()}
    return {f"outlines: {title}": _moments(scene) for title, scene in built.items()}


def _moments(scene: Scene) -> tuple[Row, ...]:
    path = simulate(scene, RUN)
    motion = Motion(scene, path)
    shapes = outlines(scene.name)
    ends = {shape.body: [motion.point(shape.body, end)[0] for end in shape.ends] for shape in shapes}
    seats = {
        part.body_b: [motion.point(part.body_b, end)[0] for end in (part.point_1, part.point_2)]
        for part in scene.contacts
        if isinstance(part, CircleOnLine)
        and part.name.endswith((".seat_base", ".seat_back"))
        and ".restraint." not in part.name
    }
    shown: list[Row] = []
    for k, time in enumerate(map(float, path.times[1:]), 1):
        shown += [_line(time, "seat", p[k], q[k], 0.0) for p, q in seats.values()]
        for shape in shapes:
            start, end = (place[k] for place in ends[shape.body])
            shown.append(_line(time, "arm" if shape.body in ARMS else "body", start, end, shape.radius))
    return tuple(shown)


def _line(time: float, kind: str, start: np.ndarray, end: np.ndarray, radius: float) -> Row:
    (x1, y1), (x2, y2) = (tuple(round(float(x), 4) for x in place[:2]) for place in (start, end))
    return {"time": time, "kind": kind, "x1": x1, "y1": y1, "x2": x2, "y2": y2, "radius": radius}
