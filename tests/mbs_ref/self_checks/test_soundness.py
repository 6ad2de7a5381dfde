"""What is looked at before and after a run, so that no success is a lie."""

from __future__ import annotations

import math
import signal
from dataclasses import dataclass

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.integrators.loop.leg import Integrator, Leg, Options
from mbs_ref.scene import Force, PlanarBody, Scene, UserForce
from mbs_ref.scene.signals import HalfSine, Table
from mbs_ref.self_checks.resolution import resolution
from mbs_ref.self_checks.soundness import UnsoundScene, clock_troubles, require_sound
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
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
    assert clock_troubles(pushed(Table(times=(0.0, 1.0, 1.0, 2.0), values=(0.0, 1.0, 2.0, 0.0)))) == []
    assert len(clock_troubles(pushed(Table(times=(0.0, 1.0, 1.0 + 1e-15), values=(0.0, 1.0, 2.0))))) == 1


@dataclass
class Oscillator:
    """What `resolution` asks of a system: x'' = -rate^2 x."""

    rate: float  # rad/s
    scene: Scene
    n_positions: int = 3

    def set_mode_time(self, t: float) -> None:
        return None

    def midpoint(self, system, options, run, y, times) -> Leg:
        """Order 2, in steps of options.step."""
        states = np.array([y, y])
        for _ in range(round((times[1] - times[0]) / options.step)):
            half = states[1] + 0.5 * options.step * self.slope(states[1])
            states[1] += options.step * self.slope(half)
        return Leg(states, np.zeros(2), 2, Status.SUCCESS)

    def slope(self, y: np.ndarray) -> np.ndarray:
        return np.concatenate((y[3:], -(self.rate**2) * y[:3]))


@pytest.mark.parametrize(("rate", "lost"), [(0.1, False), (150.0, True)])
def test_one_step_against_two_halves_tells_whether_a_step_follows_the_motion(rate, lost):
    system = Oscillator(rate, pushed(Table(times=(0.0,), values=(0.0,))))
    times = np.linspace(0.0, 1.0, 11)
    swing = np.array([np.r_[np.cos(rate * t), 0, 0, -rate * np.sin(rate * t), 0, 0] for t in times])
    method = Integrator("midpoint", "fixed", 2, "a test", system.midpoint)
    options = Options(0.01, 1e-8, 1e-8, False, False, 1000, 1e-14, 10, 100)
    found = resolution(system, method, options, times, swing, swing[:0])  # pyright: ignore[reportArgumentType]
    assert found.lost is lost, found
    assert found.body == "sled"


def test_a_fixed_step_that_is_too_long_for_the_motion_does_not_pass_for_success():
    fine = simulate(scenes.make("pendulum"), Settings(method="rk4", step=0.01, samples=11))
    assert fine.ok, fine.message
    coarse = simulate(scenes.make("pendulum"), Settings(method="rk4", step=0.5, samples=11))
    assert not coarse.ok
    assert "bob" in coarse.message


def test_a_step_that_ends_at_a_breakpoint_is_not_judged_across_it():
    scene = pushed(HalfSine(peak=1e4, duration=0.1, start=0.5))
    path = simulate(scene, Settings(method="rk4", step=0.02, t_end=1.0))
    assert path.ok, path.message


def test_a_run_that_stops_names_time_body_joint_and_the_last_good_output():
    scene = scenes.make("double_pendulum")
    path = simulate(scene, Settings(method="rk4", step=1e-3, max_steps=100, samples=31))
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
    path = simulate(scene, Settings(method="dop853", rtol=1e-10, t_end=3.0, samples=301))
    assert path.status is Status.INTERRUPTED, path.message
    assert 1 < len(path.times) < 301
    assert np.all(np.isfinite(path.position))
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
