"""What a scene is, counted: printed before a run, so that a forgotten joint or millimetres for metres are seen."""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from cross_checks.records.numbers import count
from mbs_ref import Scene
from mbs_ref.cores.choice import compile_scene
from mbs_ref.scene.joints import Drive
from mbs_ref.scene.scales import scales_of
from mbs_ref.simulate.linearised import stiffness_at_start
from mbs_ref.simulate.start_checks import rank_at_start

FEW = 60  # bodies up to which the motion is linearised


@dataclass(frozen=True)
class Summary:
    """A scene in numbers."""

    bodies: int
    groups: int  # of bodies that no joint connects; what the ground carries side by side is apart
    joints: int
    loops: int  # closed ones, the ground counted as a body
    freedoms: int | None  # at the start; None where the rank of the constraints is not computed
    length: float  # m, the scene's own
    mass: float  # kg
    fastest_hz: float | None  # of the motion linearised at the start; None where nothing swings or it is not computed

    def sentence(self) -> str:
        """Return it in one line."""
        apart = f" in {self.groups} groups that no joint connects" if 1 < self.groups < self.bodies else ""
        freedoms = "freedoms not counted" if self.freedoms is None else f"{count(self.freedoms, 'degree')} of freedom"
        fast = "" if self.fastest_hz is None else f", fastest frequency {self.fastest_hz:.3g} Hz"
        return (
            f"{self.bodies} {'body' if self.bodies == 1 else 'bodies'}{apart}, {count(self.joints, 'joint')}, "
            f"{count(self.loops, 'closed loop')}, {freedoms}; "
            f"size {self.length:.3g} m, mass {self.mass:.3g} kg{fast}"
        )


def summary(scene: Scene) -> Summary:
    """Count a scene's bodies, joints, loops and freedoms, and linearise its motion at the start."""
    free, tree = freedoms(scene), len(scene.bodies) + 1 - _groups(scene, with_ground=True)  # joints of a tree
    fastest = stiffness_at_start(scene).fastest if len(scene.bodies) <= FEW and free != 0 else 0.0
    return Summary(
        len(scene.bodies), _groups(scene, with_ground=False), len(scene.joints), len(_links(scene)) - tree, free,
        scales_of(scene).length, math.fsum(body.mass for body in scene.bodies),
        fastest / (2.0 * np.pi) if fastest > 0.0 and np.isfinite(fastest) else None,
    )  # fmt: skip


def freedoms(scene: Scene) -> int | None:
    """Return the degrees of freedom at the start: coordinates less the rank of the constraints."""
    system = compile_scene(scene)
    if system.n_closure_rows == 0:
        return system.n_coordinates - system.n_constraints
    rank = rank_at_start(system, system.initial_state())
    return None if rank is None else system.n_coordinates - rank


def _links(scene: Scene) -> list[tuple[str, str]]:
    """Return the two bodies of every joint; a drive moves a coordinate and connects nothing."""
    return [joint.ends for joint in scene.joints if not isinstance(joint, Drive)]


def _groups(scene: Scene, with_ground: bool) -> int:
    """Return the number of groups that joints connect."""
    names = [*scene.body_names, *(["ground"] if with_ground else [])]
    index = {name: k for k, name in enumerate(names)}
    pairs = [(index[one], index[other]) for one, other in _links(scene) if one in index and other in index]
    rows, columns = np.array(pairs, dtype=int).reshape(-1, 2).T
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), (rows, columns)), shape=(len(names), len(names)))
    return int(scipy.sparse.csgraph.connected_components(graph, directed=False)[0])
