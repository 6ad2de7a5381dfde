"""method = "auto": particles, stiff and ordinary motions get their method, at the accuracy that was asked for."""

from dataclasses import replace

import numpy as np
import pytest

from cross_checks.judge.one_run import evaluate
from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators import integrators
from mbs_ref.integrators.loop.leg import Leg
from mbs_ref.settings import Settings
from mbs_ref.simulate import method_choice, simulate
from mbs_ref.simulate.linearised import stiffness_at_start
from mbs_ref.simulate.method_choice import largest_eigenvalue, stability_radius
from mbs_ref.simulate.plan import make_plan
from mbs_ref.trajectory import Status

AUTO = Settings(method="auto", estimate="off", reactions=False)


def same(a, b):
    return all(
        np.array_equal(getattr(a, part), getattr(b, part))
        for part in ("times", "position", "orientation", "velocity", "angular_velocity")
    )


def test_particles_get_the_method_made_for_them():
    scene = scenes.make("pleiades")
    run = simulate(scene, AUTO)
    assert (run.method, run.reason) == ("gauss", "specific to particles")
    assert "method auto is gauss: specific to particles" in run.notes
    slack = integrators()["gauss"].slack
    assert run.used["rtol"] == 1e-8 / slack
    assert same(run, simulate(scene, AUTO.model_copy(update={"method": "gauss", "rtol": 1e-8 / slack})))


@pytest.mark.parametrize("asked", [{"step": 1e-3}, {"stabilization": "projection"}])
def test_what_the_special_method_lacks_leaves_the_default(asked):
    run = simulate(scenes.make("kepler", orbits=1.0), AUTO.model_copy(update=asked | {"samples": 5}))
    assert run.method == "dop853"
    assert run.reason.startswith("the default, because ")


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
def test_a_stack_at_rest_is_stiff(rtol):
    run = simulate(scenes.make("box_stack"), AUTO.model_copy(update={"rtol": rtol}))
    fine = simulate(scenes.make("box_stack"), AUTO.model_copy(update={"rtol": 1e-12, "method": "dop853"}))
    assert run.method == "radau"
    assert run.reason.startswith("stiff: ")
    assert np.max(np.abs(run.position - fine.position)) < 10 * rtol


def test_a_stack_that_falls_before_it_rests_is_stiff_once_its_contacts_close():
    scene = scenes.make("box_stack")
    system = compile_scene(scene)
    rest = system.poses(system.initial_state()[None])
    raised = rest._replace(position=rest.position + np.array([0.0, 0.02]))
    run, other = (simulate(scene, AUTO.model_copy(update={"method": m, "rtol": 1e-6}), None, raised)
                  for m in ("auto", "dop853"))  # fmt: skip
    assert run.method == "radau"
    assert run.rhs_calls < 0.5 * other.rhs_calls
    assert np.max(np.abs(run.position[-1] - other.position[-1])) < 1e-4


@pytest.mark.parametrize(("name", "span", "made"), [
    ("block_stack", None, 2), ("android_vertebral", None, 0), ("android_vertebral", 0.5, 2),
])  # fmt: skip
def test_trials_cost_a_small_share_of_the_run(monkeypatch, name, span, made):
    """The first one is the default's; each factorisation of 288 states costs as much as 550 of its evaluations."""
    trials = []

    class Counted(method_choice._Trial):
        def __init__(self, *values):
            super().__init__(*values)
            trials.append(self)

    monkeypatch.setattr(method_choice, "_Trial", Counted)
    simulate(scenes.make(name), AUTO.model_copy(update={"t_end": span, "samples": 5}))
    assert len(trials) == made


@pytest.mark.parametrize("name", ["pendulum", "slider_crank", "car_axis", "bouncing_ball", "flyball_governor"])
def test_other_motions_run_as_by_default_to_the_bit(name):
    settings = AUTO.model_copy(update={"t_end": 0.5, "samples": 5})
    run, plain = (simulate(scenes.make(name), settings.model_copy(update={"method": m})) for m in ("auto", "dop853"))
    assert run.method == "dop853"
    assert same(run, plain)
    assert run.events == plain.events


def test_small_planar_trees_are_expanded_in_series():
    scene = scenes.make("double_pendulum")
    run, plain = (simulate(scene, Settings(method=method, rtol=1e-10)) for method in ("auto", "dop853"))
    assert (run.method, run.reason) == ("taylor", "series of a small planar tree")
    assert np.max(np.abs(run.position - plain.position)) < 1e-8
    assert simulate(scenes.make("pendulum_chain", links=33), AUTO).method == "dop853"


def test_few_particles_are_expanded_in_series():
    run, other = (simulate(scenes.make("kepler"), Settings(method=method, rtol=1e-10)) for method in ("auto", "gauss"))
    assert (run.method, run.reason) == ("taylor", "series of few particles")
    assert np.max(np.abs(run.position - other.position)) < 1e-7
    assert simulate(scenes.make("satellite", zonals=True), AUTO).method == "gauss"


def test_a_method_that_breaks_down_is_replaced(monkeypatch):
    def stuck(system, options, run, y, times):
        return Leg(y[None], np.zeros(1), 1, Status.NOT_CONVERGED, "stuck")

    monkeypatch.setitem(integrators(), "taylor", replace(integrators()["taylor"], advance=stuck))
    scene = scenes.make("kepler", orbits=1.0)
    run = simulate(scene, AUTO)
    assert run.ok
    assert run.method == "dop853"
    assert "taylor failed: stuck" in run.reason
    assert same(run, simulate(scene, AUTO.model_copy(update={"method": "dop853"})))


def test_powers_find_the_fastest_eigenvalue():
    scene = scenes.make("box_stack")
    system = compile_scene(scene)
    y = system.initial_state()
    system.set_mode_time(0.0)
    system.start_contacts(0.0, y, True)
    units = make_plan(scene, Settings(), None).options.units
    assert largest_eigenvalue(system, units, y) == pytest.approx(stiffness_at_start(scene).fastest, rel=0.5)


def test_the_stability_radius_of_the_classical_method():
    radius = stability_radius(integrators()["rk4"].stability)
    assert radius == pytest.approx(2.785, abs=0.06)  # Hairer and Wanner II, table IV.2


def test_a_record_tells_which_method_it_was():
    record = evaluate(scenes.make("kepler", orbits=1.0), "mbs_ref", Settings(method="auto", samples=5))
    assert (record.method, record.settings["method"]) == ("taylor", "auto")
