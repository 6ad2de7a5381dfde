from benchmarks.pick import pick as pick
from benchmarks.sweep import sweep as sweep
from cross_checks.engine import Engine as Engine
from cross_checks.judge.library import check as check
from cross_checks.judge.library import run as run
from cross_checks.judge.runs import Runs as Runs
from cross_checks.records.frames import frame as frame
from cross_checks.records.frames import samples as samples
from cross_checks.trajectory_files.library import judge as judge
from reports.drawing import figures as figures

from . import engines as engines
