"""A pin in the tooth gaps of a sprocket in space: against a closed form, and as in the plane wherever that plane is."""

import math

import numpy as np
import pytest
from pydantic import ValidationError

from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene, SpatialBody
from mbs_ref.scene.contact import PinOnSprocket, RegularisedCoulomb, SpringDamperLaw
from mbs_ref.scene.euler_parameters import from_axis_angle, rotation_matrices
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.equilibrium import restated

TURN = from_axis_angle((1.0, -2.0, 0.5), 1.1)  # of the plane in space
FRAME = rotation_matrices(TURN)  # columns: the plane's x, y and normal
TEETH, PITCH, CLEARANCE = 9, 0.5, 0.02
SHAPE = {"teeth": TEETH, "pitch_radius": PITCH, "addendum_radius": 0.6, "clearance": CLEARANCE}
TIGHT = Settings(rtol=1e-11, samples=41, estimate="off")


def _in_space(*place: float) -> tuple[float, ...]:
    return tuple((FRAME[:, :2] @ place).tolist())


def _pin_in_seat(stiffness: float, speed: float, duration: float) -> Scene:
    """A pin in the middle of the third seat of a sprocket on ground, on its way inwards."""
    angle = 0.3 + 2 * 2.0 * math.pi / TEETH
    radial = np.array([math.cos(angle), math.sin(angle)])
    center, velocity = _in_space(*(PITCH * radial)), _in_space(*(-speed * radial))
    tooth = PinOnSprocket(
        name="tooth", body_a="pin", center=center, body_b=GROUND, axle=(0.0, 0.0, 0.0), axis=tuple(FRAME[:, 2]),
        seat=tuple(FRAME[:, 0]), first_seat=0.3, law=SpringDamperLaw(stiffness=stiffness), **SHAPE,
    )  # fmt: skip
    pin = SpatialBody(name="pin", mass=2.0, inertia=(0.1, 0.2, 0.2, 0.0, 0.0, 0.0), position=center, velocity=velocity)
    return Scene(name="seat", duration=duration, bodies=(pin,), contacts=(tooth,))


def test_a_pin_bounces_off_the_bottom_of_its_seat_as_a_spring_lets_it():
    """It falls freely through the clearance, turns back in half a period of the spring, and flies back."""
    stiffness, speed = 2e4, 0.8
    back = 2.0 * CLEARANCE / speed + math.pi * math.sqrt(2.0 / stiffness)
    path = simulate(_pin_in_seat(stiffness, speed, back), TIGHT)
    assert path.position[-1] == pytest.approx(path.position[0], abs=1e-9)
    assert path.velocity[-1] == pytest.approx(-path.velocity[0], abs=1e-8)
    depth, force = path.contacts["tooth"][:, 0].max(), np.linalg.norm(path.contacts["tooth"][:, 1:4], axis=-1).max()
    assert force == pytest.approx(stiffness * depth, rel=1e-9)


def _planar(friction: float) -> Scene:
    """A pin thrown at the flank of a wheel that turns."""
    rub = RegularisedCoulomb(coefficient=friction, speed=0.05)
    pin = PlanarBody(name="pin", mass=1.0, inertia=0.02, position=(PITCH + 0.03, 0.02), velocity=(-1.5, 0.1))
    wheel = PlanarBody(name="wheel", mass=5.0, inertia=0.5, angular_velocity=2.0)
    tooth = PinOnSprocket(
        name="tooth", body_a="pin", center=pin.position, body_b="wheel", axle=(0.0, 0.0), first_seat=0.05,
        law=SpringDamperLaw(stiffness=3e4, damping=20.0), friction=rub, **SHAPE,
    )  # fmt: skip
    hub = Revolute(name="hub", body_a=GROUND, body_b="wheel", point=(0.0, 0.0))
    return Scene(name="wheel", duration=0.2, bodies=(pin, wheel), joints=(hub,), contacts=(tooth,))


def _lifted(plane: Scene) -> Scene:
    """The same bodies and parts in the turned plane."""
    normal = tuple(FRAME[:, 2].tolist())
    bodies = tuple(
        SpatialBody(
            name=b.name, mass=b.mass, inertia=(b.inertia,) * 3 + (0.0,) * 3, position=_in_space(*b.position),
            orientation=tuple(TURN.tolist()), velocity=_in_space(*b.velocity),
            angular_velocity=tuple((FRAME[:, 2] * b.angular_velocity).tolist()),
        )
        for b in plane.bodies
    )  # fmt: skip
    (tooth,), origin = plane.contacts, (0.0, 0.0, 0.0)
    own = {"center": _in_space(*tooth.center), "axle": origin, "axis": normal, "seat": _in_space(1.0, 0.0)}
    hub = Revolute(name="hub", body_a=GROUND, body_b="wheel", point=origin, axis=normal)
    return Scene(
        name="lifted",
        duration=plane.duration,
        bodies=bodies,
        joints=(hub,),
        contacts=(PinOnSprocket(**dict(tooth) | own),),
    )


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_sprocket_in_space_moves_its_pin_as_in_the_plane(friction):
    plane = _planar(friction)
    flat, path = simulate(plane, TIGHT), simulate(_lifted(plane), TIGHT)
    assert flat.events >= 2
    assert path.position @ FRAME == pytest.approx(np.pad(flat.position, ((0, 0), (0, 0), (0, 1))), abs=1e-8)
    assert path.angular_velocity @ FRAME[:, 2] == pytest.approx(flat.angular_velocity, abs=1e-6)


def test_a_sprocket_that_is_restated_goes_on_as_before():
    scene = _lifted(_planar(0.3))
    whole, half = simulate(scene, TIGHT), simulate(scene, TIGHT.model_copy(update={"t_end": 0.5 * scene.duration}))
    rest = simulate(restated(scene, half), TIGHT.model_copy(update={"t_end": 0.5 * scene.duration}))
    assert rest.position[-1] == pytest.approx(whole.position[-1], abs=1e-8)


def test_a_sprocket_in_space_needs_an_axis_and_a_seat_across_it():
    scene = _lifted(_planar(0.0))
    (tooth,) = scene.contacts
    for change, words in (
        ({"axis": None, "seat": None}, "needs an axis"), ({"seat": None}, "go together"),
        ({"seat": tooth.axis}, "perpendicular"),
    ):  # fmt: skip
        with pytest.raises(ValidationError, match=words):
            Scene(**dict(scene) | {"contacts": (PinOnSprocket(**dict(tooth) | change),)})
