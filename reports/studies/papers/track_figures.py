"""The tracked vehicle of the second paper: compliance under its integrators, wheels that slide and roll, engines."""

from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.contact import own_engine
from mbs_ref import Scene, Settings, Status, Trajectory, scenes
from mbs_ref.crash.stops import tension
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import rolling_slip
from mbs_ref.observables.distance import distances, farthest
from mbs_ref.scene import SpringDamper
from mbs_ref.simulate import simulate
from reports.facts.curves import Curves, Measured, Value, curves, film
from reports.studies.crash import RAN, largest_gap

BARE: dict[str, Any] = {"model": "paper"}
ROUGH: dict[str, Any] = {"suspension": True, "ground": "bump", "height": 0.05}
WHEELS = ("idler", "roller1", "roller2", "roller3")
BRIEF, SHORT, LONG = 0.05, 0.5, 2.0  # s: for DASSL, which takes seconds; for engines and methods; for pictures
REFERENCE = Settings(method="rk4", step=5e-5, reactions=False, estimate="off")
TESTED = ("rk4", "euler", "lsodar")  # the papers' own
DRIVERS = (("pinocchio", "rk4", 1e-4), ("exudyn", "generalized_alpha", 1e-4))
OWN_STEP = 2e-4  # s, of MuJoCo's Euler with its own contacts


def measure_track() -> Measured:
    """Drive the rolling vehicle by each method and engine; the rough one for pictures."""
    figures: dict[str, Value] = {}
    scene, times = scenes.make("tracked_vehicle"), np.linspace(0.0, SHORT, 26)
    fine = simulate(scene, REFERENCE, times)
    for method, more in RAN["methods"]["track"].items():
        bare: dict[str, Any] = {"stabilization": "none"} if method in TESTED else {}
        settings = Settings(method=method, **more, **bare, reactions=False, estimate="off", max_steps=10**6)
        path = simulate(scene, settings.model_copy(update={"stop_on_compliance": method in TESTED}), times)
        name = f"track.{method}"
        figures |= {
            f"{name}.test": "fails" if path.status is Status.COMPLIANCE else "keeps" if path.ok else path.message,
            f"{name}.until": float(path.times[-1]), f"{name}.compliance": largest_gap(path),
            f"{name}.apart": farthest(scene, path, fine)[0] if path.ok else "stopped",
            f"{name}.loop_s": path.timing.loop_s,
        }  # fmt: skip
    dassl = simulate(scene, Settings(method="dassl", rtol=1e-4, t_end=BRIEF, reactions=False, estimate="off"))
    figures |= {"track.dassl.compliance": largest_gap(dassl), "track.dassl.loop_s": dassl.timing.loop_s}
    finer = Settings(method="dop853", rtol=1e-9, reactions=False)
    figures["track.pinocchio.finest_apart"] = _engine(scene, "pinocchio", finer, fine)
    for engine, method, step in DRIVERS:
        settings = Settings(method=method, step=step, reactions=False)
        figures[f"track.{engine}.apart"] = _engine(scene, engine, settings, fine)
    figures |= _held(times)
    rolled, drawn = _rolling()
    rough = scenes.make("tracked_vehicle", **ROUGH)
    path = simulate(rough, REFERENCE.model_copy(update={"step": 1e-4, "t_end": LONG, "samples": 81, "method": "rk4"}))
    hull = np.degrees(path.orientation[:, rough.body_index("chassis")])
    drawn["Hull's pitch over a bump of 5 cm, rollers sprung"] = curves(path.times, {"pitch": hull}, "degrees")
    return Measured(figures | rolled, {}, drawn, {"Track over a bump": film(rough, path, 10)})


def _held(times: np.ndarray) -> dict[str, Value]:
    """Return what wheels held on the links by constraints change, against the force law; both without friction."""
    settings = Settings(method="rk4", step=1e-4, reactions=False, estimate="off")
    scene = scenes.make("tracked_vehicle", law="constraint", **BARE)
    held, soft = simulate(scene, settings, times), simulate(scenes.make("tracked_vehicle", **BARE), settings, times)
    apart = distances(scene, held, soft)[:, scene.body_index("chassis"), 0]
    return {
        "track.held.status": str(held.status) if held.ok else held.message,
        "track.held.events": float(held.events), "track.soft.events": float(soft.events),
        "track.held.calls": held.rhs_calls / soft.rhs_calls, "track.held.compliance": largest_gap(held),
        "track.held.apart": float(apart.max()) if held.ok else "stopped",
    }  # fmt: skip


def _own_contacts(scene: Scene, ours: Trajectory) -> dict[str, Value]:
    """Return travel, speed, slip of the idler and tension by MuJoCo's own contacts, and those of our run."""
    figures: dict[str, Value] = {f"track.{name}": value for name, value in _ride(scene, ours).items()}
    try:
        settings = Settings(method="euler", step=OWN_STEP, reactions=False, initial_tolerance=1.0)
        path = own_engine("mujoco").run(scene, settings, ours.times)
    except engines.EngineMissing:
        return figures
    theirs = _ride(scene, path) if path.ok else {"message": path.message}
    return figures | {f"track.mujoco.{name}": value for name, value in theirs.items()}


def _ride(scene: Scene, path: Trajectory) -> dict[str, Value]:
    """Return what a drive comes to; slip and tension are means over its second half."""
    late, hull, idler = len(path.times) // 2, scene.body_index("chassis"), scene.body_index("idler")
    radius = next(part.radius for part in scene.contacts if part.body_a == "idler" and part.type == "circle_on_line")
    rim, speed = -radius * path.angular_velocity[late:, idler], path.velocity[late:, hull, 0]
    push = next(one for one in scene.loads if isinstance(one, SpringDamper) and one.name == "idler.tensioner")
    return {
        "travelled": float(path.position[-1, hull, 0] - path.position[0, hull, 0]), "speed": float(speed[-1]),
        "idler_slip": float(np.mean(rim) / np.mean(speed) - 1.0),
        "tension": float(-0.5 * np.mean(tension(Motion(scene, path), push)[late:])),
    }  # fmt: skip


def _engine(scene, name: str, settings: Settings, fine) -> float | str:
    try:
        path = engines.get(name).run(scene, settings, fine.times)
    except engines.EngineMissing:
        return "not installed"
    return farthest(scene, path, fine)[0] if path.ok else path.message


def _rolling() -> tuple[dict[str, Value], dict[str, Curves]]:
    """Return how well wheels roll, and that without friction nothing turns them."""
    settings = Settings(method="rk4", step=1e-4, t_end=LONG, samples=401, estimate="off")
    scene, bare = scenes.make("tracked_vehicle"), scenes.make("tracked_vehicle", **BARE)
    path, sliding = simulate(scene, settings), simulate(bare, settings)
    still = simulate(scenes.make("tracked_vehicle", torque=0.0), Settings(t_end=10.0, estimate="off", reactions=False))
    slip = {wheel: rolling_slip(Motion(scene, path), wheel) for wheel in WHEELS}
    every = np.abs(np.concatenate(list(slip.values())))
    speeds = {"chassis": path.velocity[:, scene.body_index("chassis"), 0]}
    for wheel in ("idler", "roller2"):
        radius = next(c.radius for c in scene.contacts if c.body_a == wheel and c.type == "circle_on_line")
        speeds[f"{wheel}'s rim"] = -radius * path.angular_velocity[:, scene.body_index(wheel)]
    return {
        "track.rest": float(np.abs(still.position - still.position[:1]).max()) if still.ok else still.message,
        "track.slip_median": float(np.nanmedian(every)), "track.slip_95": float(np.nanpercentile(every, 95.0)),
        "track.slip_most": float(np.nanmax(every)),
        "track.sliding_turns": float(np.abs(sliding.angular_velocity[:, [bare.body_index(w) for w in WHEELS]]).max()),
        "track.travel": float(path.position[-1, 0, 0] - path.position[0, 0, 0]),
        "track.sliding_travel": float(sliding.position[-1, 0, 0] - sliding.position[0, 0, 0]),
        **_own_contacts(scene, path),
    }, {"Track: wheels roll": curves(path.times, speeds, "m/s")}  # fmt: skip
