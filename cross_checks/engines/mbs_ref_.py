"""The project's own reference solver, behind the same contract as every engine."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from typing import ClassVar

import numpy as np

from cross_checks.engine import Engine, Method, Refusal
from cross_checks.outcome import refuse_spatial
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory
