from mbs_ref.scene import Scene as Scene
from mbs_ref.scene.toml import read_scene as read_scene
from mbs_ref.scene.toml import write_scene as write_scene
from mbs_ref.settings import Settings as Settings
from mbs_ref.simulate.equilibrium import at_equilibrium as at_equilibrium
from mbs_ref.simulate.many import ensemble as ensemble
from mbs_ref.simulate.many import simulate_scenes as simulate_scenes
from mbs_ref.simulate.many import simulate_starts as simulate_starts
from mbs_ref.simulate.one_run import simulate as simulate
from mbs_ref.trajectory import Status as Status
from mbs_ref.trajectory import Trajectory as Trajectory

from . import scene as scene
from . import scenes as scenes
