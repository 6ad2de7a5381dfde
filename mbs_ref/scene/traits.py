"""Traits of a scene, computed from its parts; engines and methods refuse scenes by them."""

from collections.abc import Callable
from typing import Any, Literal, get_args

from mbs_ref.scene.bodies import GROUND, Body, PointMass
from mbs_ref.scene.contact import Contact, ContactLaw, Friction, Granules
from mbs_ref.scene.events import Event
from mbs_ref.scene.joints import Distance, Drive, Joint, RollingWheel, UserConstraint
from mbs_ref.scene.loads import Load, UserForce
from mbs_ref.scene.scene import Scene, of_last_scene

Coordinates = Literal["cartesian", "relative"]  # of bodies, with constraint rows; or of a tree's joints, without

PART_TYPES: tuple[str, ...] = tuple(
    part.model_fields["type"].default
    for kind in (Body, Joint, Load, Contact, ContactLaw, Friction, Event)
    for part in get_args(get_args(kind)[0])
)  # of the whole language, in its order


def part_types(scene: Scene) -> frozenset[str]:
    """Return the `type` of every part the scene contains, contact laws, friction and declared events included."""
    parts = {part.type for part in (*scene.bodies, *scene.joints, *scene.loads, *scene.contacts, *scene.events)}
    laws = {contact.law.type for contact in touching(scene)}
    return frozenset(parts | laws | {c.friction.type for c in touching(scene) if c.friction is not None})


def touching(scene: Scene) -> list[Any]:
    """Return the parts by which bodies touch: contacts, and granules."""
    return [*scene.contacts, *(load for load in scene.loads if isinstance(load, Granules))]


def _any(kind: type, list_of_parts: str) -> Callable[[Scene], bool]:
    return lambda scene: any(isinstance(part, kind) for part in getattr(scene, list_of_parts))


ALL_TRAITS: dict[str, Callable[[Scene], bool]] = {
    "planar": lambda scene: scene.planar,
    "spatial": lambda scene: not scene.planar,
    # the joint graph has a cycle through bodies or ground
    "closed-loop": lambda scene: any(not isinstance(scene.joints[k], Drive) for k in joined(scene)[0]),
    # a drive prescribes a motion in time, or a constraint of the user's own may
    "rheonomic": lambda scene: any(isinstance(j, Drive) or getattr(j, "depends_on_time", False) for j in scene.joints),
    "unconstrained": lambda scene: not scene.joints,
    "constrained": lambda scene: bool(scene.joints),
    "point-mass": _any(PointMass, "bodies"),  # some body is a particle
    "free-body": lambda scene: not joined(scene)[1],  # some body has no chain of joints to ground
    "breakpoints": lambda scene: bool(scene.breakpoints()),  # a declared signal has a jump or kink
    "rod-in-space": lambda scene: not scene.planar and _any(Distance, "joints")(scene),
    "contact": lambda scene: bool(touching(scene)),  # bodies touch and part: forces or speeds jump
    "friction": lambda scene: any(contact.friction is not None for contact in touching(scene)),
    "user-force": _any(UserForce, "loads"),
    "user-constraint": _any(UserConstraint, "joints"),
    "nonholonomic": _any(RollingWheel, "joints"),  # a wheel rolls without slipping: constraints on velocities alone
}


@of_last_scene
def traits(scene: Scene) -> frozenset[str]:
    """Return the scene's traits (keys of ALL_TRAITS)."""
    return frozenset(name for name, holds in ALL_TRAITS.items() if holds(scene))


def is_smooth(scene: Scene) -> bool:
    """Return whether no force or speed jumps or bends: nothing touches, no spring slackens, no signal has a kink."""
    slackens = any(getattr(load, "tension_only", False) for load in scene.loads)
    return not (touching(scene) or slackens or scene.breakpoints())


def python_parts(scene: Scene) -> list[tuple[str, str]]:
    """Return place and name of every part that holds a Python function: it goes into no file and no other process."""
    lists = {"joints": scene.joints, "loads": scene.loads}
    every = [(f"{field}[{k}]", part) for field, parts in lists.items() for k, part in enumerate(parts)]
    return [(place, part.name) for place, part in every if callable(getattr(part, "function", None))]


def deflecting(scene: Scene) -> list[str]:
    """Return the contacts whose sticking adds states: all that can stick in space."""
    return [c.name for c in scene.contacts if scene.dimension == 3 and c.friction and c.friction.STICKS]


@of_last_scene
def joined(scene: Scene) -> tuple[list[int], bool]:
    """Return the joints that close a cycle, and whether joints hold every body to ground."""
    group = {name: {name} for name in (GROUND, *scene.body_names)}  # of what joints hold together, by each member
    closing = []
    for k, joint in enumerate(scene.joints):
        smaller, larger = sorted([group[end] for end in joint.ends], key=len)
        if smaller is larger:
            closing.append(k)
        else:
            larger |= smaller
            group |= dict.fromkeys(smaller, larger)
    return closing, len(group[GROUND]) == len(group)
