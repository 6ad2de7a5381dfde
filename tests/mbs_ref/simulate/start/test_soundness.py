"""What is looked at before and after a run, so that no success is a lie."""

from __future__ import annotations

import math
import os
import signal
from threading import Timer

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.scene import Force, PlanarBody, Scene, UserForce
from mbs_ref.scene.signals import HalfSine, Table
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.plan import CHUNK
from mbs_ref.simulate.start_checks import UnsoundScene, clock_troubles, require_sound
from mbs_ref.trajectory import Status


def changed(**fields) -> Scene:
    """Return the double pendulum with fields of its first body replaced past the checks."""
    scene = scenes.make("double_pendulum")
    first, second = scene.bodies
    return scene.model_copy(update={"bodies": (first.model_copy(update=fields), second)})


@pytest.mark.parametrize(
    "fields", [{"mass": -1.0}, {"mass": 0.0}, {"inertia": math.nan}, {"position": (math.inf, 0.0)}, {"mass": "heavy"}]
)
def test_a_copy_with_a_senseless_number_is_refused_by_name_and_value(fields):
    with pytest.raises(UnsoundScene, match=rf"upper.*{next(iter(fields))}"):
        simulate(changed(**fields))


@pytest.mark.parametrize("name", scenes.names())
def test_every_scene_of_the_project_is_sound(name):
    require_sound(scenes.make(name))


def pushed(factor) -> Scene:
    force = Force(name="push", body="sled", point=(0.0, 0.0), vector=(1.0, 0.0), factor=factor)
    return Scene(name="sled", bodies=(PlanarBody(name="sled", mass=1.0, inertia=1.0),), loads=(force,))


def test_a_pulse_that_the_clock_cannot_tell_from_nothing_is_refused():
    assert clock_troubles(pushed(HalfSine(peak=1.0, duration=1e-3, start=1e3))) == []
    found = clock_troubles(pushed(HalfSine(peak=1.0, duration=1e-3, start=1e13)))
    assert len(found) == 1
    assert "'push'" in found[0]
    # a pulse is as long as it is late: the clock is the coarser, where it ends
    assert "at t = 2.96439e-323 s" in clock_troubles(pushed(HalfSine(peak=1.0, duration=1.5e-323, start=1.5e-323)))[0]
    assert clock_troubles(pushed(Table(times=(0.0, 1.0, 1.0, 2.0), values=(0.0, 1.0, 2.0, 0.0)))) == []
    assert len(clock_troubles(pushed(Table(times=(0.0, 1.0, 1.0 + 1e-15), values=(0.0, 1.0, 2.0))))) == 1


def test_a_run_that_stops_names_time_body_joint_and_the_last_good_output():
    scene = scenes.make("double_pendulum")
    path = simulate(scene, Settings(method="rk4", step=1e-3, max_steps=100, samples=31, estimate="off"))
    assert path.status is Status.TOO_MANY_STEPS
    for word in ("t = 0.1 s", "body '", "joint '", "last good output is at t = 0.1 s"):
        assert word in path.message


def test_ctrl_c_keeps_what_was_computed():
    rung = []

    def slow(t, q, v):
        if t > 0.5 and not rung:
            rung.append(t)
            signal.raise_signal(signal.SIGINT)
        return np.zeros((2, 3))

    scene = scenes.make("double_pendulum").model_copy(update={"loads": (UserForce(name="slow", function=slow),)})
    path = simulate(scene, Settings(method="dop853", rtol=1e-10, t_end=3.0, samples=301, estimate="off"))
    assert path.status is Status.INTERRUPTED, path.message
    assert 1 < len(path.times) < 301
    assert np.all(np.isfinite(path.position))
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_ends_a_large_run_inside_its_compiled_loop():
    scene = scenes.make("pendulum_chain", links=20)
    timer = Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    try:
        path = simulate(scene, Settings(method="dop853", rtol=1e-10, t_end=1e4, samples=3, estimate="off"))
    finally:
        timer.cancel()  # a run that ends before it leaves no signal to a later test
    assert path.status is Status.INTERRUPTED, path.message
    assert path.steps < CHUNK
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
