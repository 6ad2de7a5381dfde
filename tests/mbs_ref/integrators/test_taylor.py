"""Taylor series of planar trees: their equations, order, closed forms, events and refusals."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.integrators.methods.taylor import order_of
from mbs_ref.kernels.relative import series as trees
from mbs_ref.scene import PlanarBody, PointMass, Revolute, Scene, TorsionSpring, Weld
from mbs_ref.scene.events import CoordinateEvent
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Status
from tests.mbs_ref.integrators.series_defect import defect

FINE = Settings(rtol=1e-12, estimate="off")
SERIES = FINE.model_copy(update={"method": "taylor"})


def branched(**more) -> Scene:
    """A tree with a branch, bodies that are named against their order, a weld, a particle and torsion springs."""
    bodies = (
        PlanarBody(name="tip", mass=1.0, inertia=0.1, position=(2.1, -0.3), angle=0.4),
        PlanarBody(name="arm", mass=2.0, inertia=0.2, position=(0.5, 0.1), angle=0.2),
        PlanarBody(name="side", mass=0.7, inertia=0.1, position=(0.8, -0.6), angle=-0.3),
        PlanarBody(name="cap", mass=0.4, inertia=0.05, position=(2.6, -0.2), angle=1.0),
        PointMass(name="bob", mass=0.3, position=(3.0, 0.1), velocity=(0.0, 0.0)),
    )
    joints = (
        Revolute(name="j0", body_a="ground", body_b="arm", point=(0.0, 0.0)),
        Revolute(name="j1", body_a="arm", body_b="tip", point=(1.2, 0.1)),
        Revolute(name="j2", body_a="side", body_b="arm", point=(0.9, -0.1)),
        Weld(name="w", body_a="tip", body_b="cap", point=(2.3, 0.0)),
        Revolute(name="j3", body_a="cap", body_b="bob", point=(3.0, 0.1)),
    )
    springs = (
        TorsionSpring(name="k0", body_a="ground", body_b="arm", stiffness=3.0, damping=0.2, rest_angle=0.5),
        TorsionSpring(name="k1", body_a="tip", body_b="side", stiffness=2.0, damping=0.3),
    )
    return Scene(
        name="branched", gravity=(0.3, -9.81), duration=2.0, bodies=bodies, joints=joints, loads=springs, **more
    )


@pytest.mark.parametrize("scene", [branched(), scenes.make("pendulum_chain", links=9)], ids=["branched", "chain"])
def test_a_series_obeys_the_equations_of_the_recursion(scene):
    """Until 0.04 s, where terms of order 25 are roundoff, and with an error of the order where they are not."""
    system = compile_scene(scene, "relative")
    off = partial(defect, trees, system, np.random.default_rng(1).standard_normal(len(system.initial_state())))
    assert max(off(24, h) for h in (0.0, 0.02, 0.04)) < 1e-11
    assert math.log2(off(9, 0.06) / off(9, 0.03)) == pytest.approx(9.0, abs=1.0)


@pytest.mark.parametrize("coordinates", ["cartesian", "relative"])
def test_runs_agree_with_dop853(coordinates):
    scene, own = branched(), SERIES.model_copy(update={"coordinates": coordinates})
    run, other = simulate(scene, own), simulate(scene, FINE)
    assert run.status is Status.SUCCESS
    for part in ("position", "orientation", "velocity", "angular_velocity"):
        assert np.abs(getattr(run, part) - getattr(other, part)).max() < 1e-9, part


def test_the_error_follows_the_tolerance_and_the_work_hardly():
    scene = scenes.make("double_pendulum")
    truth = simulate(scene, FINE.model_copy(update={"rtol": 1e-13})).position
    runs = [simulate(scene, SERIES.model_copy(update={"rtol": rtol})) for rtol in (1e-4, 1e-6, 1e-8, 1e-10)]
    errors = [np.abs(run.position - truth).max() for run in runs]
    assert all(error < 10.0 * rtol for error, rtol in zip(errors, (1e-4, 1e-6, 1e-8, 1e-10), strict=True)), errors
    assert runs[-1].steps < 2 * runs[0].steps
    assert [order_of(rtol) for rtol in (1e-4, 1e-30)] == [10, 28]


def test_no_step_is_chosen_by_terms_that_vanish():
    """Released at rest with its rods level a chain has every fourth term alone, so that two of any order may vanish."""
    scene = scenes.make("pendulum_chain", links=2)
    truth = simulate(scene, FINE).position
    for order in range(10, 22):
        rtol = next(x for x in np.logspace(-3, -13, 400) if order_of(x) == order)
        error = np.abs(simulate(scene, SERIES.model_copy(update={"rtol": rtol})).position - truth).max()
        assert error < 10.0 * rtol, order


def test_a_pendulum_returns_after_its_period():
    """Released at 90 degrees, T = 4 K(1/2) / w0, with the complete elliptic integral K(m = 1/2) = 1.85407467730137."""
    rod = PlanarBody(name="rod", mass=2.0, inertia=0.5, position=(1.0, 0.0))
    pin = Revolute(name="pin", body_a="ground", body_b="rod", point=(0.0, 0.0))
    period = 4.0 * 1.8540746773013719 * math.sqrt((0.5 + 2.0) / (2.0 * 9.81))
    low = CoordinateEvent(name="low", body="rod", coordinate="x", crossing="falling")
    scene = Scene(name="rod", gravity=(0.0, -9.81), bodies=(rod,), joints=(pin,), duration=period, events=(low,))
    run = simulate(scene, SERIES)
    assert run.position[-1, 0] == pytest.approx([1.0, 0.0], abs=1e-11)
    assert run.event_times is not None
    assert run.event_times[:, 0] == pytest.approx([0.25 * period], abs=1e-12)


def test_a_run_stops_at_an_event_with_its_state():
    stop = CoordinateEvent(name="left", body="arm", coordinate="x", value=-0.2, action="stop")
    runs = [simulate(branched(events=(stop,)), settings) for settings in (SERIES, FINE)]
    assert [run.status for run in runs] == [Status.STOP_EVENT] * 2
    assert runs[0].times[-1] == pytest.approx(runs[1].times[-1], abs=1e-9)
    assert runs[0].position[-1, 1, 0] == pytest.approx(-0.2, abs=1e-11)


def test_outputs_do_not_shorten_steps():
    few, many = (simulate(branched(), SERIES.model_copy(update={"samples": n})) for n in (2, 400))
    assert few.steps == many.steps
    assert np.abs(few.position[-1] - many.position[-1]).max() == 0.0


def test_other_scenes_are_refused_with_their_reason():
    with pytest.raises(ValueError, match="'taylor' cannot run 'heavy_top': bodies move in space"):
        simulate(scenes.make("heavy_top"), SERIES)
    with pytest.raises(ValueError, match=r"'taylor' cannot run 'n_four_bar': .* closes a loop"):
        simulate(scenes.make("n_four_bar"), SERIES)
