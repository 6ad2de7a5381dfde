"""Integrators: tableau identities, observed orders, singular poses, breakpoints, and honest endings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.integrators import integrators
from mbs_ref.integrators.stages import radau_newton as radau
from mbs_ref.integrators.stages.tableau import DOP853, EULER, RK4
from mbs_ref.observables.constraints import constraint_rate, constraint_residual
from mbs_ref.scene import CoordinateDrive, Force, PlanarBody, PointMass, Prismatic, Scene, SpringDamper, UserForce
from mbs_ref.scene.signals import HalfSine, Table
from mbs_ref.settings import Settings
from mbs_ref.simulate import InconsistentScene, simulate
from mbs_ref.trajectory import Status

A01_END = np.array([-0.2750874625761, -0.9614192050991])  # m at 10 s, by elliptic functions
A02_B0_END = np.array([0.32845811154081562, 0.94451853817860088])  # m at 10 s, loops = 2


@pytest.mark.parametrize("tableau", [EULER, RK4, DOP853], ids=["euler", "rk4", "dop853"])
def test_tableau_identities(tableau):
    """Row sums, and the quadrature conditions sum b c^(k-1) = 1/k up to the order."""
    np.testing.assert_allclose(tableau.a.sum(axis=1), tableau.c, atol=1e-14)
    for k in range(1, tableau.order + 1):
        assert tableau.b @ tableau.c ** (k - 1) == pytest.approx(1.0 / k, abs=1e-14)
    for weights in (tableau.error, tableau.error_low):
        assert weights.sum() == pytest.approx(0.0, abs=1e-14)


def test_radau_transformation_diagonalises_its_matrix():
    """T diag(mu) T^-1 is the inverse of the Radau IIA matrix, whose rows integrate powers up to c."""
    real, mu = radau.MU_REAL, radau.MU_COMPLEX
    block = np.array([[real, 0, 0], [0, mu.real, -mu.imag], [0, mu.imag, mu.real]])
    matrix = np.linalg.inv(radau.T @ block @ radau.TI)
    for k in range(1, 4):
        np.testing.assert_allclose(matrix @ radau.C ** (k - 1), radau.C**k / k, atol=1e-13)


ORDERS = [("euler", 1, (2e-3, 1e-3, 5e-4)), ("rk4", 4, (2e-2, 1e-2, 5e-3)), ("dop853", 8, (0.05, 0.0125)),
          ("radau", 5, (2e-2, 1e-2, 5e-3)), ("generalized_alpha", 2, (1e-2, 5e-3, 2.5e-3))]  # fmt: skip


@pytest.mark.parametrize(("method", "order", "steps"), ORDERS)
def test_observed_order(method, order, steps):
    """On the double pendulum for 1 s, against the same solver at rtol 1e-13."""
    scene = scenes.make("double_pendulum")
    truth = simulate(scene, Settings(rtol=1e-13, t_end=1.0)).position[-1]
    runs = [simulate(scene, Settings(method=method, step=h, t_end=1.0, estimate="off")) for h in steps]
    errors = [np.abs(run.position[-1] - truth).max() for run in runs]
    observed = math.log(errors[-2] / errors[-1]) / math.log(steps[-2] / steps[-1])
    tolerance = 2.5 if method == "dop853" else 0.35  # order 8 meets roundoff before its asymptote: it must not be lower
    assert observed == pytest.approx(order, abs=tolerance), errors
    assert observed > order - 0.35, errors


@pytest.mark.parametrize("step", [1e-2, 1e-3, 5e-4])
@pytest.mark.parametrize("stiffness", [1e8, 1e10, 1e13])
def test_a_stiff_force_of_roundoff_does_not_end_the_iteration_of_radau(step, stiffness):
    """Each step multiplies by R(z) = (1 + 2z/5 + z^2/20) / (1 - 3z/5 + 3z^2/20 - z^3/60) (Hairer, Wanner II, IV.3)."""
    mass = PlanarBody(name="mass", mass=1.0, inertia=0.1, position=(1.01, 0.0))
    guide = Prismatic(name="guide", body_a="ground", body_b="mass", point=(1.01, 0.0), axis=(1.0, 0.0))
    spring = SpringDamper(name="spring", body_a="ground", body_b="mass", point_a=(0.0, 0.0), point_b=(1.01, 0.0),
                          stiffness=stiffness, rest_length=1.0)  # fmt: skip
    scene = Scene(name="stiff", bodies=(mass,), joints=(guide,), loads=(spring,))
    path = simulate(scene, Settings(method="radau", step=step, t_end=0.2, samples=3, estimate="off"))
    assert path.ok, path.message
    z = 1j * math.sqrt(stiffness) * step
    factor = (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)
    expected = 1.0 + 0.01 * (factor ** np.round(path.times / step)).real
    np.testing.assert_allclose(path.position[:, 0, 0], expected, atol=1e-10)


@pytest.mark.parametrize("name", ["block_stack", "librating_satellite", "car_axis"])
def test_radau_keeps_its_jacobian_as_long_as_that_pays(name):
    """Two or three iterations of three evaluations are what most steps need; a Jacobian takes one for each state."""
    path = simulate(scenes.make(name), Settings(method="radau", rtol=1e-6, estimate="off"))
    assert path.rhs_calls < 12 * path.steps


@pytest.mark.parametrize("method", ["lsodar", "dassl", "dop853", "radau"])
def test_adaptive_methods_reach_a_micrometre_on_the_chain(method):
    """And the tighter tolerance is the better answer."""
    scene = scenes.make("pendulum_chain", links=10)
    lean = Settings(samples=2, estimate="off", reactions=False)
    truth = simulate(scene, lean.model_copy(update={"rtol": 1e-12})).position[-1]
    runs = [simulate(scene, lean.model_copy(update={"method": method, "rtol": rtol})) for rtol in (1e-6, 1e-9)]
    errors = [np.abs(run.position[-1] - truth).max() for run in runs]
    assert errors[1] < 1e-6
    assert errors[1] < errors[0]


@pytest.mark.parametrize("name", ["slider_crank", "tracked_vehicle"])
def test_lsodar_gives_states_on_the_constraints(name):
    """At a tolerance far coarser than the compliance, and through the events of contact."""
    scene = scenes.make(name, **({"links": 20, "model": "paper"} if name == "tracked_vehicle" else {}))
    end = 0.02 if name == "tracked_vehicle" else 1.0
    run = simulate(scene, Settings(method="lsodar", rtol=1e-4, atol=1e-6, t_end=end, samples=37))
    assert run.ok, run.message
    assert run.step_compliance is not None
    assert run.step_compliance[:, 1].max() < 1e-12


@pytest.mark.parametrize(("method", "rtol"), [
    ("lsodar", 1e-10), pytest.param("dassl", 1e-12, marks=pytest.mark.slow),
])  # fmt: skip
def test_the_papers_methods_reach_a_micrometre_on_the_four_bar(method, rtol):
    """Through eight singular poses, crossed by leaps."""
    settings = Settings(method=method, rtol=rtol, t_end=10.0, reactions=False, estimate="off")
    run = simulate(scenes.make("n_four_bar", loops=2), settings)
    assert run.ok, run.message
    assert np.abs(2.0 * run.position[-1, 0] - A02_B0_END).max() < 1e-6


def test_a_multistep_method_without_leaps_stops_at_a_singular_pose():
    settings = Settings(method="lsodar", rtol=1e-9, t_end=10.0, stabilization="none", max_steps=20_000)
    run = simulate(scenes.make("n_four_bar", loops=2), settings)
    assert not run.ok


def test_raw_index_3_fails_or_is_poor_and_says_so():
    run = simulate(scenes.make("pendulum"), Settings(method="dassl_index3", rtol=1e-8, t_end=10.0))
    assert not run.ok
    assert "index 3" in run.message or "iteration" in run.message or "error test" in run.message


def test_an_event_right_after_the_start_is_no_failure_of_the_compliance_test():
    """A step cut short to meet the event may be shorter than roundoff in |C|; the method's own step is what counts."""
    scene = scenes.make("tracked_vehicle", links=20, preload=0.0, start="drawn")
    settings = Settings(method="dop853", rtol=1e-6, t_end=2e-3, samples=3, stop_on_compliance=True, estimate="off")
    run = simulate(scene, settings)
    assert run.ok, run.message
    assert run.events > 0
    assert run.step_compliance is not None
    assert run.step_compliance[:, 1].max() < 1e-12


def test_plain_index_2_keeps_velocities_and_lets_positions_drift():
    """C_dot = 0 holds to Newton's tolerance; C is what its errors add up to. The stabilised form holds both."""
    scene = scenes.make("slider_crank")
    drift, speed = {}, {}
    for method in ("dassl_index1", "dassl_index2", "dassl"):
        run = simulate(scene, Settings(method=method, rtol=1e-6, stabilization="none", estimate="off"))
        assert run.ok, run.message
        drift[method] = np.abs(constraint_residual(scene, run)).max()
        speed[method] = np.abs(constraint_rate(scene, run)).max()
    assert speed["dassl_index2"] < 0.05 * speed["dassl_index1"]
    assert drift["dassl"] < 1e-7  # what Newton's iteration leaves, a share of the tolerance
    assert drift["dassl_index2"] > 1e-6
    loose = simulate(scene, Settings(method="dassl_index2", rtol=1e-4, stabilization="none", estimate="off"))
    assert np.abs(constraint_residual(scene, loose)).max() > 3.0 * drift["dassl_index2"]


def test_a01_to_a_nanometre():
    run = simulate(scenes.make("pendulum"), Settings(method="dop853", rtol=1e-12, t_end=10.0))
    assert run.ok
    assert np.abs(run.position[-1, 0] - A01_END).max() < 1e-9


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-9, 1e-10, 1e-11])
def test_a02_passes_its_singular_poses(rtol):
    """Eight flat poses in 10 s; the error follows the tolerance and the loops stay closed."""
    run = simulate(scenes.make("n_four_bar", loops=2), Settings(rtol=rtol, t_end=10.0, estimate="off"))
    assert run.ok, run.message
    crank = 2.0 * run.position[-1, 0]  # its centre is half way to B0
    assert np.abs(crank - A02_B0_END).max() < max(200 * rtol, 1e-10)
    assert run.step_compliance is not None
    assert run.step_compliance[:, 1].max() < 1e-10


def test_a02_at_the_edge_of_roundoff():
    """Eight flat poses multiply roundoff by chance: of 400 tolerances about 1e-12, a twentieth err beyond 2e-10 m."""
    errors = []
    for rtol in 1e-12 * np.geomspace(0.6, 1.7, 21):
        settings = Settings(rtol=rtol, t_end=10.0, samples=2, reactions=False, estimate="off")
        run = simulate(scenes.make("n_four_bar", loops=2), settings)
        assert run.ok, run.message
        errors.append(np.abs(2.0 * run.position[-1, 0] - A02_B0_END).max())
    assert np.median(errors) < 2e-11
    assert np.quantile(errors, 0.8) < 1e-10
    assert np.quantile(errors, 0.9) < 2e-9
    assert max(errors) < 2e-7  # a few of 400 err beyond 2e-8, none beyond 6e-8


@pytest.mark.parametrize("loops", [1, 3, 5, pytest.param(8, marks=pytest.mark.slow)])
def test_any_number_of_loops_moves_alike(loops):
    """Every crank of A02 stays parallel to the first."""
    run = simulate(scenes.make("n_four_bar", loops=loops), Settings(rtol=1e-10, t_end=10.0, samples=21, estimate="off"))
    assert run.ok, run.message
    cranks = run.position[:, : loops + 1] - np.arange(loops + 1)[None, :, None] * np.array([1.0, 0.0])
    assert np.abs(cranks - cranks[:, :1]).max() < 1e-8


# --- breakpoints ----------------------------------------------------------------------------------


def _cart(*loads) -> Scene:
    """A body on a rail, free to slide."""
    body = PlanarBody(name="cart", mass=2.0, inertia=1.0)
    rail = Prismatic(name="rail", body_a="ground", body_b="cart", point=(0.0, 0.0), axis=(1.0, 0.0))
    return Scene(name="cart", bodies=(body,), joints=(rail,), loads=loads, duration=10.0)


@pytest.mark.parametrize("method", ["dop853", "radau", "lsodar", "dassl"])
def test_a_millisecond_pulse_in_a_quiet_run_is_never_missed(method):
    """15 kN for 1 ms at 7 s: 30/pi N s of a half-sine, which adaptive codes step over without breakpoints."""
    pulse = HalfSine(peak=15e3, duration=1e-3, start=7.0)
    scene = _cart(Force(name="hit", body="cart", point=(0.0, 0.0), vector=(1.0, 0.0), factor=pulse))
    run = simulate(scene, Settings(method=method, rtol=1e-8, samples=3))
    assert run.ok, run.message
    impulse = 15e3 * 1e-3 * 2 / math.pi
    assert run.velocity[-1, 0, 0] == pytest.approx(impulse / 2.0, rel=1e-6)


@pytest.mark.parametrize(("method", "settings"), [("rk4", {"step": 0.013}), ("dop853", {}), ("radau", {})])
def test_a_switch_between_two_steps_costs_no_accuracy(method, settings):
    """A force that jumps at an odd time: polynomial pieces are integrated exactly."""
    switch = Table(times=(0.3171, 0.3171, 0.8), values=(0.0, 1.0, 1.0))
    scene = _cart(Force(name="on", body="cart", point=(0.0, 0.0), vector=(4.0, 0.0), factor=switch))
    run = simulate(scene, Settings(method=method, t_end=1.0, **settings))
    since = 1.0 - 0.3171
    assert run.position[-1, 0, 0] == pytest.approx(0.5 * 2.0 * since**2, abs=1e-11)


def test_a_driven_seat_and_a_pulse_in_its_frame_move_alike():
    """Prescribed acceleration of the base equals the mass-proportional force with the base at rest."""
    pulse, rest = HalfSine(peak=-180.0, duration=0.08, start=0.01), Table(times=(0.0,), values=(0.0,))
    drive = CoordinateDrive(name="d", body="seat", coordinate="x", motion=pulse, level="acceleration")
    hold = [CoordinateDrive(name=c, body="seat", coordinate=c, motion=rest) for c in ("y", "angle")]
    spring = SpringDamper(
        name="k", body_a="seat", body_b="rider", point_a=(0.0, 0.0), point_b=(0.5, 0.0), stiffness=3e3, damping=40
    )
    seat = PlanarBody(name="seat", mass=5.0, inertia=1.0)
    rider = PointMass(name="rider", mass=2.0, position=(0.5, 0.0), velocity=(0.0, 0.0))
    driven = Scene(name="driven", bodies=(seat, rider), joints=(drive, *hold), loads=(spring,), duration=0.2)
    push = Force(name="f", body="rider", point=(0.5, 0.0), vector=(-2.0, 0.0), factor=pulse)
    still = [CoordinateDrive(name=c, body="seat", coordinate=c, motion=rest) for c in ("x", "y", "angle")]
    held = Scene(name="held", bodies=(seat, rider), joints=tuple(still), loads=(spring, push), duration=0.2)
    runs = [simulate(scene, Settings(rtol=1e-12)) for scene in (driven, held)]
    relative = [run.position[:, 1] - run.position[:, 0] for run in runs]
    np.testing.assert_allclose(relative[0], relative[1], atol=1e-11)


# --- endings --------------------------------------------------------------------------------------


def test_statuses_name_the_time_and_the_last_good_output():
    scene = scenes.make("double_pendulum")
    run = simulate(scene, Settings(rtol=1e-9, t_end=5.0, max_steps=20))
    assert run.status is Status.TOO_MANY_STEPS
    assert "last good output" in run.message
    assert len(run.times) < 101
    assert np.isfinite(run.position).all()


def test_a_step_too_large_for_a_stiff_spring_ends_in_a_status():
    """omega = 1e5 rad/s at h = 1e-3: RK4 explodes, and nothing past the explosion is returned."""
    ball = PointMass(name="ball", mass=1.0, position=(1.0, 0.0), velocity=(0.0, 0.0))
    spring = SpringDamper(
        name="k", body_a="ground", body_b="ball", point_a=(0, 0), point_b=(1, 0), stiffness=1e10, rest_length=0.9
    )
    scene = Scene(name="stiff", bodies=(ball,), loads=(spring,))
    assert simulate(scene, Settings(method="rk4", step=1e-3)).status is Status.REFUSED
    run = simulate(scene, Settings(method="rk4", step=1e-3, refuse_unstable=False))
    assert run.status is Status.NON_FINITE
    assert np.isfinite(run.position).all()


def test_the_papers_compliance_test_can_stop_a_run():
    scene = scenes.make("double_pendulum")
    settings = Settings(method="euler", step=5e-3, t_end=5.0, stabilization="none", stop_on_compliance=True)
    run = simulate(scene, settings)
    assert run.status is Status.COMPLIANCE
    assert "|C| < h" in run.message


def test_baumgarte_holds_the_constraints_that_differentiation_lets_drift():
    scene = scenes.make("double_pendulum")
    drift = [
        simulate(scene, Settings(method="rk4", step=5e-3, t_end=5.0, stabilization=s)).step_compliance[:, 1].max()
        for s in ("none", "baumgarte", "projection")
    ]
    assert drift[1] < 0.3 * drift[0]
    assert drift[2] < 1e-12


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"method": "rk5"}, "method = 'rk5' is unknown"),
        ({"method": "rk4"}, "give step"),
        ({"method": "lsodar", "step": 1e-3}, "is adaptive"),
        ({"method": "dassl", "stabilization": "baumgarte"}, "does not go with"),
    ],
)
def test_settings_that_make_no_sense_are_named(settings, words):
    with pytest.raises(ValueError, match=words):
        simulate(scenes.make("pendulum"), Settings(**settings))


def test_inconsistent_velocities_are_refused_or_projected_with_their_size():
    body = PlanarBody(name="cart", mass=2.0, inertia=1.0, velocity=(1.0, 0.5))
    rail = Prismatic(name="rail", body_a="ground", body_b="cart", point=(0.0, 0.0), axis=(1.0, 0.0))
    scene = Scene(name="cart", bodies=(body,), joints=(rail,))
    with pytest.raises(InconsistentScene, match=r"joint 'rail': velocity gap 0\.5.*--project-initial .*--keep BODY\."):
        simulate(scene, Settings())
    run = simulate(scene, Settings(project_initial=True))
    assert any("0.5" in note for note in run.notes)
    assert run.velocity[-1, 0] == pytest.approx([1.0, 0.0], abs=1e-12)


def test_a_users_force_law_is_called_and_its_failure_is_reported():
    def pull(t, q, v):
        return -4.0 * q * np.array([1.0, 0.0, 0.0])

    start = PlanarBody(name="cart", mass=1.0, inertia=1.0, position=(1.0, 0.0))
    scene = Scene(name="cart", bodies=(start,), loads=(UserForce(name="pull", function=pull),))
    run = simulate(scene, Settings(rtol=1e-10, t_end=1.0))
    assert run.position[-1, 0, 0] == pytest.approx(math.cos(2.0), abs=1e-8)

    def fails(t, q, v):
        if t > 0.5:
            raise RuntimeError("no data past 0.5 s")
        return np.zeros_like(q)

    scene = Scene(name="cart", bodies=(start,), loads=(UserForce(name="fails", function=fails),))
    run = simulate(scene, Settings(rtol=1e-6, t_end=1.0))
    assert run.status is Status.ENGINE_ERROR
    assert "no data past 0.5 s" in run.message


def test_every_method_is_listed_with_its_order():
    known = integrators()
    papers, ours = {"euler", "rk4", "lsodar", "dassl"}, {"dop853", "radau", "generalized_alpha"}
    assert papers | ours | {"dassl_index1", "dassl_index2", "dassl_index3"} <= set(known)
    assert all(entry.order >= 1 and entry.description for entry in known.values())
    assert next(iter(known)) == "dop853"


def test_generalized_alpha_keeps_its_order_at_small_steps():
    """Velocities too, to whose errors a step divides what Newton's iteration leaves in the positions."""
    scene = scenes.make("pendulum_chain", links=10)
    truth = simulate(scene, Settings(rtol=1e-13, estimate="off")).angular_velocity[-1]
    steps = (1.0 / 7000.0, 1.0 / 36000.0)
    runs = [simulate(scene, Settings(method="generalized_alpha", step=h, estimate="off")) for h in steps]
    errors = [np.abs(run.angular_velocity[-1] - truth).max() for run in runs]
    assert math.log(errors[0] / errors[1]) / math.log(steps[0] / steps[1]) == pytest.approx(2.0, abs=0.05), errors


def test_rounding_of_the_clock_leaves_no_step_of_nearly_nothing():
    """1875 steps of 4e-5 s miss an output by 6e-14 s, and a step of that length would divide roundoff by its square."""
    settings = Settings(method="generalized_alpha", step=4e-5, t_end=2.1, samples=29, estimate="off")
    run = simulate(scenes.make("double_pendulum"), settings)
    assert run.status is Status.SUCCESS, run.message
    assert run.steps == 28 * 1875


@pytest.mark.parametrize("step", [5e-3, 1.25e-3, 6.25e-4])
def test_generalized_alpha_reaches_the_end_of_a_stiff_crash(step):
    """Steps that its contacts cut to almost nothing leave no rounding of 1 / h in the rates."""
    scene = scenes.make("android_vertebral")
    run = simulate(scene, Settings(method="generalized_alpha", step=step, estimate="off", max_steps=5000))
    assert run.ok, run.message


def test_the_tangent_of_generalized_alpha_serves_stiff_beams():
    """Its differences are of positions and of rates, not of accelerations, which move neither by enough."""
    scene = scenes.make("flexible_slider_crank")
    run = simulate(scene, Settings(method="generalized_alpha", step=scene.duration / 1000, estimate="off"))
    assert run.ok, run.message


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_implicit_methods_bear_stiff_springs(method):
    """A slow swing on a spring of 1e9 N/m: the step follows the swing, not the spring."""
    bob = PointMass(name="bob", mass=1.0, position=(1.0, 0.0), velocity=(0.0, 0.0))
    spring = SpringDamper(
        name="k", body_a="ground", body_b="bob", point_a=(0.0, 0.0), point_b=(1.0, 0.0), stiffness=1e9, damping=1e4
    )
    scene = Scene(name="stiff", gravity=(0.0, -9.81), bodies=(bob,), loads=(spring,), duration=1.0)
    accuracy = {"step": 2e-3} if method == "generalized_alpha" else {"rtol": 1e-7}
    run = simulate(scene, Settings(method=method, **accuracy))
    assert run.ok, run.message
    rigid = simulate(scenes.make("pendulum"), Settings(rtol=1e-10, t_end=1.0)).position[-1, 0] * [-1.0, 1.0]
    assert np.abs(run.position[-1, 0] - rigid).max() < 1e-3
    assert run.steps < 20_000
