"""What the papers advise, and their range of crashes: tolerances, step rules, no block inversion, orders of errors."""

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from mbs_ref import Settings, scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.crash.results import crash_results
from mbs_ref.integrators import integrators
from mbs_ref.observables.distance import farthest
from mbs_ref.scene import GROUND, Revolute, Scene, SpatialBody, TorsionSpring
from mbs_ref.scene.euler_parameters import parameter_matrix
from mbs_ref.simulate import simulate
from mbs_ref.simulate.linearised import stiffness_at_start
from reports.facts.curves import Curves, Measured, Value, plain
from reports.studies.crash import PAPER, finished
from reports.studies.papers.crash_figures import method_figures

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
RK4 = integrators()["rk4"].stability or ()
SLOW = 1e-2  # rad/s: a slower oscillation is roundoff of the differences


def measure_lessons() -> tuple[Measured, ...]:
    """Return what each lesson measures."""
    figures = step_rules() | block_inversion() | orders() | leading_matrix() | counted_rows() | soles() | softer()
    return lsodar_series(), crash_range(), Measured(figures)


def lsodar_series() -> Measured:
    """Run LSODAR on the vertebral android at ever finer tolerances, under the papers' test |C| < h and without it."""
    scene, figures = scenes.make("android_vertebral", **PAPER), {}
    for rtol in TOLERANCES:
        figures |= method_figures(f"lsodar.{rtol:g}", scene, "lsodar", {"rtol": rtol})
    reached = plain([figures[f"lsodar.{rtol:g}.until"] for rtol in TOLERANCES])
    line = Curves(TOLERANCES, {"until": reached}, "time reached under the papers' test, s", "rtol", x_log=True,
                  marks="lines+markers")  # fmt: skip
    return Measured(figures, curves={"LSODAR on the vertebral android": line})


def step_rules() -> dict[str, Value]:
    """Return the papers' step rules (Fox 1999 eqs 36-37) over contacts, and RK4's stable step, for both androids.

    A progressive contact's m/c is m/(c d), which falls with its depth d: the smallest of a run is taken.
    """
    figures: dict[str, Value] = {}
    for kind in ("simplified", "vertebral"):
        scene = scenes.make(f"android_{kind}", **PAPER)
        stiff, path = stiffness_at_start(scene), finished(scene)
        undamped = tuple(
            x.model_copy(update={"damping": 0.0} if isinstance(x, TorsionSpring) else {}) for x in scene.loads
        )
        system = compile_scene(scene)
        mobility = system.contact_oscillators(0.0, system.initial_state(), 0.0)[:, 0]
        laws = [part.law.numbers() for part in scene.contacts]
        damped = [
            law.damping * float(path.contacts[part.name][:, 0].max()) * kw / law.stiffness
            for part, law, kw in zip(scene.contacts, laws, mobility, strict=True)
        ]
        figures |= {
            f"rules.{kind}.oscillation": stiff.oscillation_rule, f"rules.{kind}.damping": 1.0 / max(damped),
            f"rules.{kind}.stable": stiff.step_limit(RK4),
            **dict(zip((f"rules.{kind}.overdamped", f"rules.{kind}.oscillating"), _restoring(scene), strict=True)),
            f"stiff.{kind}": stiff.fastest, f"stiff.{kind}.modes": float(len(stiff.eigenvalues)),
            f"stiff.{kind}.undamped": stiffness_at_start(scene.model_copy(update={"loads": undamped})).fastest,
        }  # fmt: skip
    return figures | {"rules.track.stable": stiffness_at_start(scenes.make("tracked_vehicle")).step_limit(RK4)}


def _softened(parts: Sequence[Any], factor: float) -> tuple[Any, ...]:
    """Return contacts whose laws have stiffness and damping times a factor."""
    both = ("stiffness", "damping")
    laws = [part.law.model_copy(update={name: factor * getattr(part.law, name) for name in both}) for part in parts]
    return tuple(part.model_copy(update={"law": law}) for part, law in zip(parts, laws, strict=True))


def _restoring(scene: Scene) -> tuple[float, float]:
    """Return the least c^2/(4 k I) of restoring torques (Fox 1999 eq. 31), and how many modes oscillate by them alone.

    I is the moment of inertia of the lighter part; a chain bears on its joints by more than that.
    """
    inertia = {body.name: getattr(body, "inertia", math.inf) for body in scene.bodies}
    springs = tuple(load for load in scene.loads if isinstance(load, TorsionSpring))
    ratios = [x.damping**2 / (4.0 * x.stiffness * min(inertia[name] for name in x.ends)) for x in springs]
    alone = scene.model_copy(update={"gravity": (0.0, 0.0), "contacts": (), "loads": springs})
    values = stiffness_at_start(alone).eigenvalues
    return min(ratios), float(np.sum(np.abs(np.imag(values)) > SLOW))


def leading_matrix() -> dict[str, Value]:
    """Return the condition of M and of [[M, C_q^T], [C_q, 0]] at t = 0 and the latter's negative eigenvalues."""
    figures: dict[str, Value] = {}
    for kind in ("simplified", "vertebral"):
        system = compile_scene(scenes.make(f"android_{kind}", **PAPER))
        assert isinstance(system, JointedSystem)
        rows, mass = system.jacobian(0.0, system.initial_state()), system.mass_matrix()
        whole = np.block([[np.diag(mass), rows.T], [rows, np.zeros((len(rows), len(rows)))]])
        figures |= {
            f"leading.{kind}.mass": float(mass.max() / mass.min()), f"leading.{kind}.rows": float(len(rows)),
            f"leading.{kind}.condition": float(np.linalg.cond(whole)),
            f"leading.{kind}.negative": float(np.sum(np.linalg.eigvalsh(whole) < 0.0)),
        }  # fmt: skip
    return figures


UPRIGHT, ACROSS = (0.1, 0.0, 1.0), (0.0, 1.0, 0.1)


def counted_rows() -> dict[str, Value]:
    """Swing a door on one hinge, on three in a line and on two across: rows, rank, motion (below Fox 2001 eq. 35)."""
    door = SpatialBody(name="door", mass=20.0, inertia=(2.0, 1.0, 2.0, 0.0, 0.0, 0.0), position=(0.0, 0.5, 0.0))
    figures: dict[str, Value] = {}
    paths, settings = [], Settings(rtol=1e-9, estimate="off", samples=11)
    for name, axes in (("one", (UPRIGHT,)), ("three", (UPRIGHT,) * 3), ("crossed", (UPRIGHT, ACROSS))):
        hinges = tuple(
            Revolute(name=f"hinge{k}", body_a=GROUND, body_b="door", point=tuple(k * x for x in UPRIGHT), axis=axis)
            for k, axis in enumerate(axes)
        )
        scene = Scene(name="door", duration=1.0, gravity=(0.0, 0.0, -9.81), bodies=(door,), joints=hinges)
        system = compile_scene(scene)
        assert isinstance(system, JointedSystem)
        rank = np.linalg.matrix_rank(system.scaled_jacobian(0.0, system.initial_state()))
        paths.append(finished(scene, settings))
        figures |= {f"hinges.{name}.rows": 2.0 * len(axes), f"hinges.{name}.rank": float(rank)}
    moved = float(np.abs(paths[2].position - paths[2].position[0]).max())
    return figures | {"hinges.apart": farthest(scene, *paths[:2])[0], "hinges.crossed.moved": moved}


SOLES = (2, 5)  # contact points of a foot


def soles() -> dict[str, Value]:
    """Return the largest force (N) on a point of the sole, whose stiffness and damping its points share."""
    scene, figures = scenes.make("android_simplified"), {}
    heel, ball = (next(c for c in scene.contacts if c.name == f"foot.{end}.floor") for end in ("heel", "ball"))
    rest = tuple(c for c in scene.contacts if c not in (heel, ball))
    for count in SOLES:
        share = np.linspace(0.0, 1.0, count)
        points = tuple(
            heel.model_copy(update={
                "name": f"sole{k}", "radius": float(heel.radius + s * (ball.radius - heel.radius)),  # type: ignore[attr-defined]
                "center": tuple(float(a + s * (b - a)) for a, b in zip(heel.center, ball.center, strict=True)),  # type: ignore[attr-defined]
            })
            for k, s in enumerate(share)
        )  # fmt: skip
        path = finished(scene.model_copy(update={"contacts": (*rest, *_softened(points, 2.0 / count))}))
        pressed = [np.hypot(*path.contacts[f"sole{k}"][:, 1:3].T).max() for k in range(count)]
        figures[f"sole.{count}"] = float(max(pressed))
    return figures


def softer() -> dict[str, Value]:
    """Return what contacts of a tenth of the stiffness and damping save, and how far (m) they move the android."""
    scene = scenes.make("android_simplified", **PAPER)
    one, other = finished(scene), finished(scene.model_copy(update={"contacts": _softened(scene.contacts, 0.1)}))
    return {"softer.calls": other.rhs_calls / one.rhs_calls, "softer.apart": farthest(scene, one, other)[0]}


def block_inversion() -> dict[str, Value]:
    """Return how a turning body's equations are solved by inverting A = 4 E^T J E, and whole (Fox 2001 eq. 35).

    The exact accelerations follow from Euler's equations; errors are relative to them.
    """
    inertia, theta, omega = np.diag([0.2, 0.3, 0.4]), np.array([0.1, 0.7, -0.5, 0.5]), np.array([1.0, -2.0, 3.0])
    rates = parameter_matrix(theta)  # E: omega = 2 E theta_dot
    turning = np.linalg.solve(inertia, -np.cross(omega, inertia @ omega))
    exact = 0.5 * rates.T @ turning - 0.25 * (omega @ omega) * theta
    a, row = 4.0 * rates.T @ inertia @ rates, theta[None]
    right = np.append(a @ exact, theta @ exact)
    whole = np.block([[a, row.T], [row, np.zeros((1, 1))]])
    try:
        inverse = np.linalg.inv(a)
        multiplier = (row @ inverse @ right[:4] - right[4:]) / (row @ inverse @ row.T)[0]
        inverted: Value = _relative(inverse @ (right[:4] - theta * multiplier), exact)
    except np.linalg.LinAlgError as error:
        inverted = str(error)
    return {
        "block.rank": float(np.linalg.matrix_rank(a)), "block.condition": float(np.linalg.cond(a)),
        "block.whole_condition": float(np.linalg.cond(whole)), "block.error": inverted,
        "block.whole_error": _relative(np.linalg.solve(whole, right)[:4], exact),
    }  # fmt: skip


def _relative(solved: np.ndarray, exact: np.ndarray) -> float:
    return float(np.linalg.norm(solved - exact) / np.linalg.norm(exact))


def orders() -> dict[str, Value]:
    """Return the orders of local errors (one step) and global ones (a fixed time): p + 1 and p for stable methods."""
    scene, figures = scenes.make("slider_crank"), {}
    fine = Settings(method="dop853", rtol=1e-13, estimate="off", reactions=False)
    for method, step in (("rk4", 4e-3), ("euler", 4e-4)):
        for kind in ("local", "global"):
            errors = []
            for h in (step, 0.5 * step):
                times = np.array([0.0, h if kind == "local" else 100.0 * step])
                coarse = simulate(scene, Settings(method=method, step=h, estimate="off", reactions=False), times)
                errors.append(max(farthest(scene, coarse, simulate(scene, fine, times))))
            figures[f"errors.{method}.{kind}"] = math.log2(errors[0] / errors[1])
    return figures


MASSES, DURATIONS, SPEEDS = (50.0, 75.0, 100.0), (0.1, 0.15, 0.2), (40.0, 50.0, 60.0)  # kg, s, km/h


def crash_range() -> Measured:
    """Run the believable simplified android over the papers' range of mass, duration and change of speed.

    The exponents a, b, c of HIC36 ~ m^a T^b dv^c are fitted to all runs.
    """
    rows, forces = [], []
    for mass, duration, speed in product(MASSES, DURATIONS, SPEEDS):
        mean = mass * speed / 3.6 / duration  # N, Fox 1999 eq. 35
        crash = {"mass": mass, "speed_change_km_h": speed, "peak_force": 0.5 * math.pi * mean}
        scene = scenes.make("android_simplified", **crash)
        rows.append((mass, duration, speed, crash_results(scene, finished(scene)).measures["HIC36"]))
        forces.append(mean)
    table = np.array(rows)
    logs = np.log(table)
    fit = np.linalg.lstsq(np.column_stack((logs[:, :3], np.ones(len(logs)))), logs[:, 3], rcond=None)[0]
    figures: dict[str, Value] = {
        "range.force_least": min(forces), "range.force_most": max(forces), "range.runs": float(len(rows)),
        "range.HIC36_least": float(table[:, 3].min()), "range.HIC36_most": float(table[:, 3].max()),
        **{f"range.exponent.{name}": float(x) for name, x in zip(("mass", "duration", "speed"), fit, strict=False)},
    }  # fmt: skip
    middle = table[table[:, 0] == MASSES[1]]
    lines = {f"{t:g} s": plain(middle[middle[:, 1] == t, 3]) for t in DURATIONS}
    drawn = Curves(SPEEDS, lines, "HIC36 at 75 kg", "change of speed, km/h", marks="lines+markers")
    return Measured(figures, curves={"HIC over the papers' range of crashes": drawn})
