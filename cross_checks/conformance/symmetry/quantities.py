"""What kind of quantity each field of a scene's parts is: how it turns, and what its unit is made of."""

from __future__ import annotations

from typing import Any

# field -> kind. Polar vectors turn with space; axial ones (a sense of rotation) change sign in a mirror as well.
POINTS = frozenset({
    "position", "point", "point_a", "point_b", "center", "center_a", "center_b", "point_1", "point_2", "axle",
})  # fmt: skip
POLAR = frozenset({"velocity", "vector", "gravity", "direction", "normal", "edge", "x_axis", "y_axis"})
AXIAL = frozenset({"angular_velocity", "spin", "axis", "axis_a", "axis_b"})
TURNED_BY_ANGLE = frozenset({"angle", "first_seat"})  # angles in the plane against the world's x axis
SENSE_OF_ROTATION = frozenset({"torque", "rest_angle"})  # scalars of the plane that a mirror reverses
# where a field's kind is not that of its name
KINDS: dict[tuple[str, str], str] = {
    ("torque_vector", "vector"): "axial",
    ("prismatic", "axis"): "polar",
    ("oblateness", "axis"): "polar",
}
# parts that single out places, directions or dates, or that are no data
NOT_FREE = frozenset({
    "coordinate_drive", "coordinate_event", "user_force", "third_body", "radiation_pressure", "drag", "standard_drag",
    "lunar_figure", "ring", "tide",
})  # fmt: skip

LENGTH, SPEED, ACCELERATION, STIFFNESS = (0, 1, 0), (0, 1, -1), (0, 1, -2), (1, 0, -2)
# field -> powers of kg, m, s
DIMENSIONS: dict[str, tuple[float, float, float]] = {
    **dict.fromkeys(POINTS, LENGTH),
    **dict.fromkeys(("radius", "radius_a", "radius_b", "length", "rest_length", "size", "thickness"), LENGTH),
    **dict.fromkeys(("pitch_radius", "addendum_radius", "clearance"), LENGTH),
    "mass": (1, 0, 0), "inertia": (1, 2, 0), "velocity": SPEED, "angular_velocity": (0, 0, -1),
    "gravity": ACCELERATION, "torque": (1, 2, -2), "stiffness": STIFFNESS, "damping": (1, 0, -1), "gm": (0, 3, -2),
    "c": SPEED, "speed": SPEED, "slowest": SPEED, "duration": (0, 0, 1),
}  # fmt: skip
DIMENSIONS_OF_PARTS: dict[tuple[str, str], tuple[float, float, float]] = {
    ("force", "vector"): (1, 1, -2),
    ("torque_vector", "vector"): (1, 2, -2),
    ("torsion_spring", "stiffness"): (1, 2, -2),
    ("torsion_spring", "damping"): (1, 2, -1),
    ("progressive_law", "damping"): (1, -1, -1),
}
POWER_LAWS = frozenset({"hunt_crossley_law", "lankarani_nikravesh_law", "flores_law"})


def kind(part: str, field: str) -> str:
    """Return "point", "polar", "axial", "angle", "sense" or "scalar"."""
    named = KINDS.get((part, field))
    if named:
        return named
    tables = (("point", POINTS), ("polar", POLAR), ("axial", AXIAL), ("angle", TURNED_BY_ANGLE))
    return next((name for name, table in (*tables, ("sense", SENSE_OF_ROTATION)) if field in table), "scalar")


def dimension(part: Any, field: str) -> tuple[float, float, float]:
    """Return the powers of kg, m and s of a field of a part; zeros where it is a number."""
    if part.type in POWER_LAWS and field in ("stiffness", "damping"):
        return (1, 1 - part.exponent, -2) if field == "stiffness" else (1, -part.exponent, -1)
    return DIMENSIONS_OF_PARTS.get((part.type, field), DIMENSIONS.get(field, (0, 0, 0)))
