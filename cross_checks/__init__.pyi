from cross_checks.engine import Engine as Engine
from cross_checks.judge.library import check as check
from cross_checks.judge.library import run as run
from cross_checks.judge.runs import Runs as Runs
from cross_checks.prices.pick import pick as pick
from cross_checks.prices.sweep import sweep as sweep
from cross_checks.records import figures as figures
from cross_checks.records.frames import frame as frame
from cross_checks.records.frames import samples as samples
from cross_checks.trajectory_files.library import judge as judge

from . import engines as engines
