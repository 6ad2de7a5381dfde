"""What a scene is, in words and numbers, and a film of its motion: the head of its page."""

from dataclasses import dataclass

from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.facts.curves import Film, film
from reports.scene_summary import Summary, summary

PICTURES = 40  # of a film
MOST_BODIES = 120  # of a scene that is filmed: others take minutes


@dataclass(frozen=True)
class SceneFacts:
    """The mechanism of a scene."""

    scene: str  # its label
    description: str
    source: str  # where the data come from; empty where they are this project's own
    duration: float  # s
    summary: Summary
    film: Film | None
    unfilmed: str = ""  # why there is no film


def scene_facts(scene: Scene) -> SceneFacts:
    """Return a scene's facts; it is simulated by the default method."""
    path, why = filmed(scene)
    shown = None if path is None else film(scene, path, 1)
    label = scenes.label(scene.name, scene.parameters)
    return SceneFacts(label, scene.description, scene.source, scene.duration, summary(scene), shown, why)


def filmed(scene: Scene) -> tuple[Trajectory | None, str]:
    """Return the motion that a film shows, or None and the sentence why there is none."""
    if len(scene.bodies) > MOST_BODIES:
        again = f"`mbs-ref animate {scene.name} -o film.gif` films it"
        return None, f"Not filmed here: {len(scene.bodies)} bodies; {again}"
    path = simulate(scene, Settings(samples=PICTURES, estimate="off", reactions=False))
    return (path, "") if path.ok else (None, f"Not filmed: {path.message}")
