"""Questions across the border between integrators and cores."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from numba.core.errors import TypingError

from mbs_ref import scenes
from mbs_ref.cores.choice import compile_scene
from mbs_ref.kernels import answers as core
from mbs_ref.kernels.border.handles import QUESTIONS
from mbs_ref.kernels.residual import largest_balance

OTHERS_ARE_NOT_COMPILED = """
from mbs_ref import scenes
from mbs_ref.kernels.particles import dynamics as particles
from mbs_ref.kernels.planar import dynamics as planar
from mbs_ref.kernels.spatial import dynamics as spatial
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

assert simulate(scenes.make("pendulum"), Settings(t_end=0.01, samples=2, estimate="off")).ok
assert planar.planar_derivative.overloads
assert not spatial.spatial_derivative.overloads and not particles.particle_derivative.overloads
"""


def test_a_planar_scene_compiles_no_other_core():
    subprocess.run([sys.executable, "-c", OTHERS_ARE_NOT_COMPILED], check=True)


def test_an_array_that_is_not_contiguous_is_refused():
    system = compile_scene(scenes.make("pendulum"))
    y = np.repeat(system.initial_state(), 2)
    with pytest.raises(TypingError, match="derivative"):
        core.call_derivative(system.model, system.work, 0.0, y[::2], np.empty(len(y) // 2))


def test_a_question_that_was_not_prepared_for_raises():
    system = compile_scene(scenes.make("pendulum"))
    y = system.initial_state()
    arguments = system.model, system.work, 0.0, y, np.zeros_like(system.scratch.rows.multiplier), np.zeros(len(y) // 2)
    with pytest.raises(RuntimeError, match="prepared"):
        largest_balance(*arguments)
    system.prepare(core.FORM)
    assert largest_balance(*arguments) == pytest.approx(9.81, rel=0.01)


def test_a_scene_that_is_only_checked_compiles_nothing():
    assert not {"handles", "model", "work"} & vars(compile_scene(scenes.make("pendulum"))).keys()


@pytest.mark.parametrize("group", [core.MOTION, core.FORM, core.REPORT])
def test_both_rigid_cores_answer_the_same_questions(group):
    planar, spatial = (core.ANSWERS[name][group] for name in ("planar", "spatial"))
    assert planar.keys() == spatial.keys()


def test_a_handle_begins_with_addresses():
    system = compile_scene(scenes.make("pendulum"))
    model, work = system.handles
    assert (model[:QUESTIONS] != 0).all()
    assert (work[:QUESTIONS] == model[:QUESTIONS]).all()
