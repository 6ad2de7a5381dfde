"""The contact problem of one instant, and by how much an engine's step violates Signorini's and Coulomb's conditions.

Contact velocities u and impulses r obey u = W r + q with W the Delassus matrix and q the velocities without impulses
after a step; for each contact 0 <= u_N, r_N >= 0, u_N r_N = 0, |r_T| <= mu r_N, and r_T opposes a sliding u_T.
Components are the normal one, then the tangential ones. Everything is assembled from world poses, apart from any
engine. Files have the names and layout of FCLIB's local problems (Acary et al., INRIA RT-0444, 2014).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.sparse import csc_array

from cross_checks import engines
from cross_checks.contact.by_figure import RTOL, motion, run
from cross_checks.contact.request import ContactModel
from cross_checks.judge.vocabulary import OURS
from cross_checks.truths.oracle import Augmented, Moment, augmented, unit_rates
from mbs_ref import Scene, Settings, Trajectory
from mbs_ref.observables.contact_gap import relative_motion, shapes_known
from mbs_ref.scene.base.part import normals
from mbs_ref.scene.signals import Constant
from mbs_ref.scene.traits import traits
from mbs_ref.simulate.equilibrium import restated

ITERATIONS = 20_000  # of the projected gradient ...
RESOLVED = 1e-12  # of the largest impulse: ... which ends once a step changes them by less


@dataclass(frozen=True)
class Instant:
    """The contacts that may touch within a step from one state of a scene, which is its start."""

    scene: Scene
    system: Augmented
    step: float  # s
    contacts: tuple[str, ...]  # n of them
    rows: np.ndarray  # (n d, n_q) H: u = H v
    friction: np.ndarray  # (n,) mu

    @cached_property
    def delassus(self) -> np.ndarray:
        """W (n d, n d), 1/kg, within the joints."""
        still = np.zeros((len(self.system.gamma), len(self.rows)))
        return self.rows @ self._response(self.rows.T, still)

    @cached_property
    def free(self) -> np.ndarray:
        """The velocities (n d,), m/s, after a step without contact."""
        v = self.system.moment.rate[self.system.moment.used]
        return self.rows @ (v + self.step * self._response(self.system.force, self.system.gamma))

    def _response(self, load: np.ndarray, gamma: np.ndarray) -> np.ndarray:
        """Return the accelerations of a load within the joints."""
        c = self.system.jacobian
        matrix = np.block([[self.system.mass, c.T], [c, np.zeros((len(c), len(c)))]])
        return np.linalg.lstsq(matrix, np.concatenate((load, gamma)))[0][: len(self.system.mass)]


def state_at(scene: Scene, time: float) -> Scene:
    """Return the scene that starts in its state at a time (s), by the reference solver; ValueError if it has none."""
    if time == 0.0:
        return scene
    signals = [signal for part in (*scene.loads, *scene.joints) for signal in part.signals]
    if "rheonomic" in traits(scene) or not all(isinstance(signal, Constant) for signal in signals):
        raise ValueError(f"{scene.name}: its signals would begin anew at t = {time:g} s; only t = 0 is allowed")
    path = _reached(scene, time)
    if isinstance(path, str):
        raise ValueError(f"{scene.name}: no state at t = {time:g} s: {path}")
    return restated(scene, path)


def _reached(scene: Scene, time: float) -> Trajectory | str:
    settings = Settings(rtol=RTOL, atol=RTOL, reactions=False, estimate="off", initial_tolerance=1.0)
    return motion(engines.get(OURS), scene, settings, np.array((0.0, time)))


def instant(scene: Scene, step: float) -> Instant:
    """Return the problem of a scene's first step (s); ValueError where nothing touches within it."""
    system = augmented(Moment.start(scene))
    units, known = unit_rates(system.moment), [c for c in scene.contacts if shapes_known(c)]
    rows, near = [], []
    for contact in known:
        gap, normal, relative = relative_motion(units, contact)
        n = normal[0]
        frame = np.vstack((n, (n[1], -n[0]) if len(n) == 2 else normals(n)))  # the normal and the tangents (d, d)
        mine = frame @ (relative[:-1] - relative[-1]).T
        v = system.moment.rate[system.moment.used] + step * np.linalg.solve(system.mass, system.force)
        if gap[0] <= 0.0 or gap[0] + step * (mine[0] @ v) <= 0.0:
            rows.append(mine)
            near.append(contact)
    if not near:
        raise ValueError(f"{scene.name}: no contact touches within a step of {step:g} s from the start")
    friction = np.array([getattr(contact.friction, "coefficient", 0.0) for contact in near])
    return Instant(scene, system, step, tuple(contact.name for contact in near), np.vstack(rows), friction)


def write(problem: Instant, path: Path) -> None:
    """Write FCLIB's local problem: HDF5 if the name ends in .hdf5 (needs h5py), else a NumPy archive of its names."""
    w, n = csc_array(problem.delassus), len(problem.free)
    matrix = {"m": n, "n": n, "nzmax": w.nnz, "nz": -1, "p": w.indptr, "i": w.indices, "x": w.data}
    plain = {"spacedim": problem.scene.dimension, "vectors/q": problem.free, "vectors/mu": problem.friction}
    named = plain | {f"W/{name}": value for name, value in matrix.items()}
    arrays = {f"fclib_local/{name}": np.atleast_1d(value) for name, value in named.items()}
    arrays = {name: x.astype(np.intc) if x.dtype.kind == "i" else x for name, x in arrays.items()}
    if path.suffix != ".hdf5":
        return np.savez(path, **arrays)  # type: ignore[arg-type]
    import h5py  # type: ignore[import-not-found]

    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file.create_dataset(name, data=values)


@dataclass(frozen=True)
class Violation:
    """By how much contact velocities and the impulses nearest to them violate the conditions; 0 for a solution."""

    engine: str
    method: str
    penetrating: float | None = None  # m/s, largest -u_N
    pushing_apart: float | None = None  # J, sum of u_N r_N
    not_opposed: float | None = None  # J, sum of mu r_N |u_T| + r_T u_T: friction that slides without its full force
    unexplained: float | None = None  # m/s, of u - q that no impulses inside the friction cones give
    residual: float | None = None  # m/s, |W| times the largest change of r by one projection, 0 for solutions alone
    reason: str = ""


def violation(problem: Instant, u: np.ndarray, engine: str = "", method: str = "") -> Violation:
    """Assess contact velocities (n d,), m/s; the impulses are the nearest in energy inside the friction cones."""
    r = nearest_impulses(problem, u)
    speeds, impulses = (x.reshape(len(problem.contacts), -1) for x in (u, r))
    sliding = np.linalg.norm(speeds[:, 1:], axis=1)
    lost = problem.friction * impulses[:, 0] * sliding + np.sum(impulses[:, 1:] * speeds[:, 1:], axis=1)
    left = np.abs(u - problem.free - problem.delassus @ r).max()
    return Violation(
        engine, method, float(max(0.0, -speeds[:, 0].min())), float(np.abs(speeds[:, 0] * impulses[:, 0]).sum()),
        float(lost.sum()), float(left), natural_residual(problem, r),
    )  # fmt: skip


def natural_residual(problem: Instant, r: np.ndarray) -> float:
    """Return |W| max |r - P(r - (u + mu |u_T| n)/|W|)|, m/s, of impulses r (n d,) and their u = W r + q.

    P projects on the friction cones. The residual vanishes for solutions alone (Acary et al. 2014, the natural map).
    """
    size, u = np.linalg.norm(problem.delassus, 2), problem.delassus @ r + problem.free
    shifted = u.reshape(len(problem.contacts), -1).copy()
    shifted[:, 0] += problem.friction * np.linalg.norm(shifted[:, 1:], axis=1)
    return float(size * np.abs(r - _projected(problem, r - shifted.ravel() / size)).max())


def nearest_impulses(problem: Instant, u: np.ndarray) -> np.ndarray:
    """Return the r in the friction cones that minimises r W r / 2 - r (u - q), by accelerated projected gradients."""
    w, change = problem.delassus, u - problem.free
    rate, r = 1.0 / np.linalg.norm(w, 2), np.zeros_like(change)
    before = r
    for k in range(ITERATIONS):
        ahead = r + k / (k + 3.0) * (r - before)  # Nesterov 1983
        before, r = r, _projected(problem, ahead - rate * (w @ ahead - change))
        if np.abs(r - before).max() <= RESOLVED * np.abs(r).max():
            break
    return r


def _projected(problem: Instant, r: np.ndarray) -> np.ndarray:
    """Return the nearest impulses inside the friction cones |r_T| <= mu r_N."""
    mu, impulses = problem.friction, r.reshape(len(problem.contacts), -1).copy()
    normal, size = impulses[:, 0].copy(), np.linalg.norm(impulses[:, 1:], axis=1)
    inside = size <= mu * normal
    along = np.where(inside, normal, np.maximum(normal + mu * size, 0.0) / (1.0 + mu**2))
    impulses[:, 0] = along
    impulses[:, 1:] *= np.where(inside, 1.0, mu * along / np.where(size > 0.0, size, 1.0))[:, None]
    return impulses.ravel()


def assess(problem: Instant, models: Iterable[ContactModel]) -> list[Violation]:
    """Return the violations of one step by the reference solver with the scene's laws and by engines' own contacts."""
    scene = problem.scene.model_copy(update={"duration": problem.step})
    method = engines.get(OURS).method(None).name
    runs: list[tuple[str, str, Trajectory | str]] = [(OURS, method, _reached(scene, problem.step))]
    runs += [(model.engine.name, method.name, run(model, method.name, scene, problem.step))
             for model in models for method in model.engine.methods()]  # fmt: skip
    found = []
    for engine, method, path in runs:
        if isinstance(path, str):
            found.append(Violation(engine, method, reason=path))
            continue
        after = Moment.of(scene, path, -1)
        found.append(violation(problem, problem.rows @ after.rate[after.used], engine, method))
    return found
