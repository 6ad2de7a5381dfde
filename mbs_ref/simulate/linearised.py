"""The linearised motion: its stiffness, the largest stable step of an explicit method, and modes about a steady motion.

Fox 2001 uses eigenvalues of the leading system and a stability constant. His rules, h below 1/omega = sqrt(m/k) and
m/c, are reported beside the eigenvalues of the linearised motion.

A motion is steady if every body's velocity (world axes) and angular velocity (body axes) is constant, and if moving
along it does not change the equations: a wheel that rolls straight on, an upright spinning top of revolution, or rest.
Such a motion y(t) = exp(t X) y(0) is at rest in a frame that moves with it, where perturbations z obey z' = (f_y - X) z
with constant matrices, although f_y itself depends on the wheels' angles along y(t). (Marsden and Ratiu, Introduction
to Mechanics and Symmetry, 2nd ed., 1999, relative equilibria.) The matrix is restricted to perturbations that satisfy
the constraints.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.cores.system import System
from mbs_ref.kernels.contact.laws import MODE_OPEN
from mbs_ref.scene import Scene, SpringDamper, TorsionSpring, UserForce
from mbs_ref.scene.signals import Constant
from mbs_ref.scene.traits import touching, traits
from mbs_ref.simulate.plan import Plan

LARGEST = 250  # bodies; the eigenvalues of more take longer than most runs
DIFFERENCE = 1e-7  # m, rad, m/s, rad/s: half a step of the central differences
GROWTH = 1.05  # factor per step beyond which a decaying or steady motion counts as unstable
UNSTABLE = 1e-3  # of the largest |lambda|: a larger real part belongs to a motion that grows by itself
LOOKS = 8  # outputs at which the step is judged after a run
_SCAN = 400  # trial steps, geometrically spaced


@dataclass(frozen=True)
class Stiffness:
    """Eigenvalues of the linearised motion at one time."""

    eigenvalues: np.ndarray  # (n,) complex, 1/s, of the closed contacts, springs and joints together
    open_contacts: np.ndarray  # (2 k,) complex, 1/s, of each contact alone as if it closed: first roots, second roots
    taut: np.ndarray  # (n,) complex, 1/s, of the motion with all strings taut; empty where there is none
    oscillation_rule: float  # s, the papers' smallest 1/omega = sqrt(m/k) over contacts; inf without
    damping_rule: float  # s, the papers' smallest m/c over contacts; inf without
    contact_slopes: np.ndarray  # (k,) N/m, of each contact's law

    @property
    def modes(self) -> np.ndarray:
        """All eigenvalues for which a step must be stable."""
        return np.concatenate((self.eigenvalues, self.open_contacts, self.taut))

    @property
    def fastest(self) -> float:
        """The largest |lambda|, 1/s."""
        return float(np.max(np.abs(self.modes), initial=0.0))

    @property
    def fastest_decay(self) -> float:
        """The largest decay rate, 1/s."""
        return float(np.max(-np.real(self.modes), initial=0.0))

    def of_contact(self, k: int) -> "Stiffness":
        """Return what the k-th contact alone is like while it is closed."""
        own = self.open_contacts[k :: len(self.contact_slopes)]
        return replace(self, eigenvalues=np.zeros(0), open_contacts=own, taut=np.zeros(0))

    def step_limit(self, stability: tuple[float, ...]) -> float:
        """Return the largest step (s) for a stability polynomial, lowest power first; inf where nothing is fast."""
        fast = self.modes[np.real(self.modes) <= UNSTABLE * self.fastest]
        fast = fast[np.abs(fast) > 1e-2 * self.fastest]
        if not len(fast):
            return np.inf
        steps = np.geomspace(1e-3, 50.0, _SCAN)[:, None] / np.max(np.abs(fast))
        grows = np.any(np.abs(np.polynomial.polynomial.polyval(steps * fast, stability)) > GROWTH, axis=1)
        return float(steps[max(int(np.argmax(grows)) - 1, 0), 0]) if grows.any() else np.inf


def stiffness(system: System, t: float, y: np.ndarray, speed: float = 0.0) -> Stiffness:
    """Linearise the motion at (t, y) in the current contact modes; contacts must have been started.

    Contacts are linearised where an impact at `speed` (m/s) is deepest: at 0 a law such as Hertz's has no stiffness.
    """
    kw, cw, slopes = system.contact_oscillators(t, y, speed).T
    with system.taut_strings() as any_string:
        taut = _eigenvalues(system, t, y) if any_string else np.zeros(0, complex)
    return Stiffness(
        eigenvalues=_eigenvalues(system, t, y),
        open_contacts=_roots(kw, cw),
        taut=taut,
        oscillation_rule=1.0 / np.sqrt(np.max(kw, initial=0.0)) if np.any(kw > 0.0) else np.inf,
        damping_rule=1.0 / np.max(cw, initial=0.0) if np.any(cw > 0.0) else np.inf,
        contact_slopes=slopes,
    )


def _roots(kw: np.ndarray, cw: np.ndarray) -> np.ndarray:
    root = np.sqrt(0.25 * cw.astype(complex) ** 2 - kw)
    return np.concatenate((-0.5 * cw + root, -0.5 * cw - root))


def fastest_contact(system: System, y: np.ndarray) -> float:
    """Return the largest |lambda| (1/s) of open contacts, each alone as if it closed at the scene's speed; else 0."""
    if not system.scene.contacts:
        return 0.0
    is_open = system.redundant.groups.contact_modes.mode[: len(system.scene.contacts)] == MODE_OPEN
    kw, cw, _ = system.contact_oscillators(0.0, y, system.scales.speed)[is_open].T
    return float(np.max(np.abs(_roots(kw, cw)), initial=0.0))


def stiffness_at_start(scene: Scene, speed: float = 0.0) -> Stiffness:
    """Linearise a scene's motion at t = 0, and contacts where an impact at `speed` (m/s) is deepest."""
    system = compile_scene(scene)
    y = system.initial_state()
    system.set_mode_time(0.0)
    system.start_contacts(0.0, y, True)
    return stiffness(system, 0.0, y, speed)


def _eigenvalues(system: System, t: float, y: np.ndarray) -> np.ndarray:
    """Return those of the derivative of dy/dt by central differences; none if very many or not finite."""
    if len(y) > 6 * LARGEST:
        return np.zeros(0, complex)
    shifts = DIFFERENCE * np.eye(len(y))
    columns = np.array([system.derivative(t, y + shift) - system.derivative(t, y - shift) for shift in shifts])
    return np.linalg.eigvals(columns.T / (2.0 * DIFFERENCE)) if np.isfinite(columns).all() else np.zeros(0, complex)


def unstable_step(system: System, plan: Plan, y: np.ndarray) -> str:
    """Return why an explicit fixed step is unstable at the start, or nothing."""
    unstable = _unstable(system, plan, 0.0, y) if plan.settings.refuse_unstable else ""
    return unstable and f"{unstable}; use a smaller step, an implicit or adaptive method, or refuse_unstable = False"


def unstable_passage(system: System, plan: Plan, times: np.ndarray, states: np.ndarray) -> tuple[str, ...]:
    """Return a note on the first of LOOKS outputs of the last run at which an explicit fixed step is unstable."""
    if not _has_limit(system, plan):
        return ()
    for k in np.unique(np.linspace(0.0, len(times) - 1.0, LOOKS).astype(int)):
        system.recall_modes(float(times[k]))
        unstable = _unstable(system, plan, float(times[k]), states[k])
        if unstable:
            return (f"at t = {times[k]:.6g} s {unstable}: the error may be larger than its estimate",)
    return ()


def _has_limit(system: System, plan: Plan) -> bool:
    """Return whether a fixed step may be too long for stability."""
    return bool(plan.options.step and plan.integrator.stability) and may_be_stiff(system.scene)


def _unstable(system: System, plan: Plan, t: float, y: np.ndarray) -> str:
    if not _has_limit(system, plan):
        return ""
    step = plan.options.step
    stiff = stiffness(system, t, y)
    limit = stiff.step_limit(plan.integrator.stability)
    if step <= limit:
        return ""
    return (
        f"step = {step:g} s is beyond what {plan.integrator.name} can bear: the fastest motion has |lambda| = "
        f"{stiff.fastest:.4g} 1/s and needs a step of at most {limit:.3g} s"
    )


def may_be_stiff(scene: Scene) -> bool:
    """Return whether the scene has parts that can be stiff at all."""
    return bool(touching(scene)) or any(isinstance(x, SpringDamper | TorsionSpring | UserForce) for x in scene.loads)


STEP = 0.01  # of a unit direction of the state: truncation ~ h^8 / 630 and roundoff ~ eps / h are both below 1e-13
WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)  # central differences of order 8 (Fornberg 1988)
STEADY = 1e-9  # of the largest rate: a smaller acceleration is roundoff
SAME = 1e-6  # of the largest entry: vector fields that differ by less are equal to the accuracy of the differences
INDEPENDENT = 1e-8  # of the largest singular value: rows with smaller ones are dependent
ZERO = 1e-10  # of the largest singular value: smaller ones belong to the kernel
NEARBY = 0.01  # size of the displacement, in state units, at which the symmetry is tested


@dataclass(frozen=True)
class SteadyMotion:
    """Modes about the motion in which a scene starts; none if it is not steady."""

    eigenvalues: np.ndarray  # (n,) complex, 1/s: one per position and velocity freedom, by falling real part
    reason: str  # why there are none, otherwise empty


def steady_motion_at_start(scene: Scene) -> SteadyMotion:
    """Linearise a scene about its motion at t = 0; if that is not steady, the result holds the reason."""
    reason = _unsupported(scene)
    if reason:
        return _none(reason)
    system = compile_scene(scene)
    assert isinstance(system, JointedSystem)
    y = system.initial_state()
    system.set_mode_time(0.0)
    f, (course, generator) = system.derivative(0.0, y), system.steady_course(y)
    rates = f[system.n_positions :] - course[system.n_positions :]
    if np.abs(rates).max() > STEADY * max(1.0, np.abs(f).max()):
        return _none("the motion at t = 0 is accelerated")
    if not _is_symmetric(system, y, course, generator):
        return _none("the equations change along the motion at t = 0")
    tangent = _tangent(system, y)
    matrix = differences(lambda x: system.derivative(0.0, x), y, tangent) - generator @ tangent
    values = _eigenvalues_of_chains(tangent.T @ matrix)
    return SteadyMotion(values[np.lexsort((np.imag(values), -np.real(values)))], "")


def _none(reason: str) -> SteadyMotion:
    return SteadyMotion(np.zeros(0, complex), reason)


def _unsupported(scene: Scene) -> str:
    """Return why a scene is not analysed, or nothing."""
    signals = [signal for part in (*scene.joints, *scene.loads) for signal in part.signals]
    if touching(scene) or traits(scene) & {"rheonomic", "user-force", "user-constraint"}:
        return "contacts, drives and user-defined laws are not analysed"
    if not all(isinstance(signal, Constant) for signal in signals):
        return "a load changes in time"
    if not scene.joints:
        return "no joint holds a body"
    return f"more than {LARGEST} bodies" if len(scene.bodies) > LARGEST else ""


def _is_symmetric(system: JointedSystem, y: np.ndarray, course: np.ndarray, generator: np.ndarray) -> bool:
    """Return whether the affine field X commutes with f, f_y X = X f, at a generic state near y."""
    near = y + NEARBY * np.cos(1.0 + np.arange(len(y)))
    along = course + generator @ (near - y)
    size = np.linalg.norm(along)
    if size == 0.0:
        return True
    moved = size * differences(lambda x: system.derivative(0.0, x), near, along[:, None] / size)[:, 0]
    turned = generator @ system.derivative(0.0, near)
    return bool(np.abs(moved - turned).max() < SAME * max(1.0, np.abs(turned).max()))


def _tangent(system: JointedSystem, y: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis (n_state, n) of the perturbations that preserve C, C_dot and the norms."""

    def conserved(x: np.ndarray) -> np.ndarray:
        rows = [np.concatenate(pair) for pair in system.residuals(0.0, x).values()]
        return np.concatenate((*rows, system.norms(x)))

    return _kernel(differences(conserved, y, np.eye(len(y))), INDEPENDENT)[0]


def _kernel(matrix: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return orthonormal bases of a matrix's kernel and of the kernel's complement."""
    _, values, basis = np.linalg.svd(matrix)
    rank = int(np.sum(values > tolerance * values.max(initial=0.0)))
    return basis[rank:].T, basis[:rank].T


def _eigenvalues_of_chains(matrix: np.ndarray) -> np.ndarray:
    """Return the eigenvalues, those of Jordan blocks at 0 exactly.

    A bicycle's place and heading have no effect, and such Jordan chains would perturb the small eigenvalues. The kernel
    is removed until it is empty (the staircase algorithm of Kublanovskaya 1966).
    """
    every = len(matrix)
    while len(matrix):
        kernel, rest = _kernel(matrix, ZERO)
        if not kernel.shape[1]:
            break
        matrix = rest.T @ matrix @ rest
    return np.concatenate((np.linalg.eigvals(matrix), np.zeros(every - len(matrix))))


def differences(f: Callable[[np.ndarray], np.ndarray], y: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return f_y directions (n_f, n) by central differences of order 8; directions (n_y, n) of length one."""
    columns = []
    for along in directions.T:
        pairs = [f(y + j * STEP * along) - f(y - j * STEP * along) for j in range(1, len(WEIGHTS) + 1)]
        columns.append(np.tensordot(WEIGHTS, pairs, axes=1) / STEP)
    return np.array(columns).T
