"""Measured tosses of a cube: files, fitted flights and laws against SciPy's rotations and integrator."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from cross_checks.contact import tosses
from mbs_ref.scene import contact as laws
from mbs_ref.trajectory import Trajectory

V, W, FLOOR = np.array((1.0, -0.5, 0.3)), np.array((4.0, 2.0, -3.0)), -0.001  # m/s, rad/s, m


def flying(n: int = 60) -> tosses.Toss:
    """A cube that flies freely from 0.4 m until it would be below the floor."""
    t = np.arange(n)[:, None] / 148.0
    turns = Rotation.from_rotvec(W * t) * Rotation.from_euler("xyz", (0.3, 0.2, 0.1))
    position = np.array((0.0, 0.0, 0.4)) + V * t - 0.5 * 9.81 * t**2 * np.array((0.0, 0.0, 1.0))
    return tosses.Toss("free", position, np.roll(turns.as_quat(), 1, axis=1))


def test_a_fitted_flight_has_the_state_of_a_free_cube():
    toss = flying()
    flight = toss.flight(FLOOR)
    lowest = toss.corners[: len(flight.times), :, 2].min()
    assert FLOOR + 1e-3 <= lowest < FLOOR + 0.03  # it ends a sample above the floor
    assert flight.velocity[0, 0] == pytest.approx(V, abs=1e-12)
    assert flight.angular_velocity[0, 0] == pytest.approx(W, abs=1e-12)
    assert toss.error(flight) < 1e-12
    straight = tosses.Toss("straight", toss.position, np.tile((1.0, 0.0, 0.0, 0.0), (len(toss.position), 1)))
    assert np.abs(straight.flight(FLOOR).angular_velocity).max() == 0.0


def test_corners_and_their_error_are_those_of_rotated_vertices():
    toss = flying(4)
    rotation = Rotation.from_quat(np.roll(toss.orientation, -1, axis=1))
    vertex = np.array((0.0524, -0.0524, 0.0524))
    assert (
        np.abs(toss.corners - (toss.position + rotation.apply(vertex))[:, None]).sum(axis=2).min(axis=1).max() < 1e-15
    )
    turned = rotation * Rotation.from_rotvec((0.0, 0.0, 0.1))  # about the body's axis: sqrt(2) of the half side away
    pose = (toss.position[:, None], np.roll(turned.as_quat(), 1, axis=1)[:, None])
    path = Trajectory(np.arange(4) / 148.0, *pose, pose[0], pose[0])
    assert toss.error(path) == pytest.approx(2.0 * np.sin(0.05) * np.sqrt(2.0) * 0.0524, rel=1e-12)


@pytest.mark.parametrize("kind", [laws.SpringDamperLaw, laws.ProgressiveLaw, laws.HuntCrossleyLaw])
def test_a_law_rebounds_as_published_at_the_chosen_depth(kind):
    law = tosses.law_of(kind)
    k, c, n, m, *_ = law.numbers()

    def force(depth, speed):
        return k * depth**n + c * depth**m * speed

    def part(t, y):
        return y[0] if y[1] < 0.0 and kind is not laws.SpringDamperLaw else force(*y) if y[1] < 0.0 else 1.0

    part.terminal = True  # type: ignore[attr-defined]
    motion = solve_ivp(lambda t, y: (y[1], -force(max(y[0], 0.0), y[1]) / 0.37), (0.0, 0.1), (0.0, 1.0), events=part,
                       rtol=1e-9, atol=1e-12, max_step=1e-5)  # fmt: skip
    assert motion.y[0].max() == pytest.approx(1e-4, rel=1e-4)
    assert -motion.y[1, -1] == pytest.approx(0.125, rel=1e-4)


def test_a_published_file_is_read_in_metres(tmp_path):
    rows = np.arange(3 * 19, dtype=float).reshape(3, 19) + 1.0
    (tmp_path / "7.pt").write_bytes(b"header of a pickle" + (57).to_bytes(8, "little") + rows.tobytes())
    (toss,) = tosses.stored(tmp_path)
    assert toss.name == "7"
    assert toss.position == pytest.approx(0.0524 * rows[:, :3])
    assert toss.orientation == pytest.approx(rows[:, 3:7] / np.linalg.norm(rows[:, 3:7], axis=1)[:, None])


def test_other_files_and_an_empty_folder_are_named(tmp_path):
    with pytest.raises(ValueError, match=r"no file of a toss, named \*\.pt"):
        tosses.stored(tmp_path)
    (tmp_path / "bad.pt").write_bytes(b"PK" + bytes(100))
    with pytest.raises(ValueError, match=r"bad\.pt: it must end with rows of 19 doubles"):
        tosses.stored(tmp_path)


def test_stored_tosses_fly_freely_to_the_noise_and_friction_predicts_them_better(monkeypatch):
    monkeypatch.setattr(tosses, "LAWS", tosses.LAWS[:1])
    stored = tosses.stored()
    floor = tosses.floor_of(stored)
    assert len(stored) == 20
    assert np.median([toss.error(toss.flight(floor)) for toss in stored]) < 2e-4  # m
    predicted = {one.model: one for one in tosses.predict(stored[1:2], {}, 1e-3)}
    rubbed, sticks, slid = (predicted[name] for name in (
        "spring_damper_law", "spring_damper_law, stick_slip", "rigid_law, no friction"))  # fmt: skip
    assert sticks.error == pytest.approx(rubbed.error, rel=1e-4), sticks.reason  # it slides and spins to rest
    assert rubbed.error < 0.03 < 0.1 < slid.error  # m; without friction the cube slides on
    assert rubbed.numerical < 1e-2 * rubbed.error
    failed = tosses.Predicted("0", "a", "b", 1e-4, reason="stops")
    none, one = tosses.summaries([failed, rubbed])
    assert (none.tosses, none.failed, none.reason) == (0, 1, "stops")
    assert one.error == rubbed.error


def test_a_sample_is_drawn_at_random_and_bounds_the_median(monkeypatch):
    """Of 100 errors the order statistics 40 and 61 contain the median with 95 % (Conover 1999, table of ranks)."""
    monkeypatch.setattr(tosses, "LAWS", tosses.LAWS[:1])
    monkeypatch.setattr(tosses, "_predicted", lambda toss, *_: toss.name)
    stored, reported = tosses.stored(), []
    names = list(tosses.predict(stored, {}, 1e-3, 7, lambda *state: reported.append(state[:2])))
    assert len(set(names)) == 7 < len(names) == 21  # by three models
    assert reported[-1] == (21, 21)
    assert names != list(tosses.predict(stored[:7], {}, 1e-3))
    with pytest.raises(ValueError, match="sample = 21 tosses; allowed: 1 to 20"):
        tosses.predict(stored, {}, 1e-3, 21)
    errors = [tosses.Predicted(str(k), "a", "b", 1e-4, float(k), 0.0) for k in range(100, 0, -1)]
    (summary,) = tosses.summaries(errors, random=True)
    assert (summary.interval, summary.error, summary.quartiles) == ("40 to 61", 50.5, "26 to 75")
    worse = [*errors[2:], *(tosses.Predicted(str(k), "a", "b", 1e-4, reason="stops") for k in range(2))]
    (missed,) = tosses.summaries(worse, random=True)  # the two largest are as good as infinite
    assert (missed.error, missed.interval, missed.failed) == (50.5, "40 to 61", 2)
    assert tosses.summaries(worse[-3:])[0].error is None  # most have failed
    assert [tosses.summaries(errors[-n:], random=True)[0].interval for n in (5, 6)] == ["", "1 to 6"]  # 1 - 2/2^n
    assert tosses.summaries(errors)[0].interval == ""


def test_a_toss_without_a_free_flight_is_refused():
    toss = tosses.Toss("low", np.zeros((5, 3)), np.tile((1.0, 0.0, 0.0, 0.0), (5, 1)))
    with pytest.raises(ValueError, match="toss low: 0 samples of free flight"):
        tosses.predict([toss], {}, 1e-3)  # before any run


def test_a_cube_that_has_come_to_lie_flat_is_not_turned_over():
    """Toss 139, rigid: a landing as slow as roundoff was aimed at a gap of centimetres."""
    place, turn, speed, spin = (
        (-0.25971780772205105, 0.01949275524962467, 0.13247088508848104),
        (-0.6628739055722792, -0.1094612735183586, -0.7402061757870556, -0.026668937695284785),
        (1.2186004901432195, -0.3010620845059177, -0.027291638205218904),
        (0.509131459167883, 3.942711209286701, 0.9405144904546637),
    )
    start = Trajectory(np.zeros(1), *(np.array([[x]]) for x in (place, turn, speed, spin)))
    toss: Any = SimpleNamespace(name="139", position=np.zeros((112, 3)), flight=lambda floor: start)
    path = tosses._ours(tosses.scene_of(toss, -0.0011523951270738034, laws.RigidLaw(restitution=0.125)), 0)
    assert isinstance(path, Trajectory), path
    height = tosses.corners(path.position[60:, 0], path.orientation[60:, 0])[..., 2]
    assert np.ptp(height, axis=0).max() < 1e-12
