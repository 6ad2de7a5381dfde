"""The shared force code as Python text, with the numbers of one scene: what adapters call, a script carries along.

Compiled functions are plain Python below their decorator. Each is written with every function, constant and table that
it names, so that nothing has to be written twice.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic

from cross_checks.engines.writers.literals import literal
from cross_checks.engines.writers.script import source, template
from cross_checks.workshop.planar_forces import AppliedForces
from cross_checks.workshop.planar_motion import arrays_of, motion_of, project
from cross_checks.workshop.planar_tree import JointTree
from cross_checks.workshop.spatial_forces import SpatialApplied
from mbs_ref.kernels.planar.dynamics import load_state as load_planar
from mbs_ref.kernels.planar.loads import planar_apply_loads
from mbs_ref.kernels.spatial.loads import spatial_apply_loads
from mbs_ref.kernels.spatial.orientation import load_state as load_spatial
from mbs_ref.scene import SpatialBody, symmetric
from mbs_ref.scene.euler_parameters import floats, rotation_matrices

ACCESSOR = "_of"  # ends the name of what gives a group of arrays of a model or of its scratch
Sources = dict[str, Any]  # what a text names, by its name
_IN_PLANE = (load_planar, planar_apply_loads, motion_of, project)


def forces_text(applied: AppliedForces | SpatialApplied) -> str:
    """Return the text of `on_bodies(t, ...)`, in the plane also of `generalized(t, q, v)`, as adapters call them."""
    system = applied.system
    planar = isinstance(applied, AppliedForces)
    named = _gathered(*(_IN_PLANE if planar else (load_spatial, spatial_apply_loads)))
    groups = [name.removesuffix(ACCESSOR) for name, value in named.items() if isinstance(value, _Intrinsic)]
    model = {name: getattr(system.groups, name) for name in groups if hasattr(system.groups, name)}
    work = {name: getattr(system.scratch, name) for name in groups if hasattr(system.scratch, name)}
    spatial = {} if planar else {
        "rigid": [(k, symmetric(b.inertia)) for k, b in enumerate(system.scene.bodies) if isinstance(b, SpatialBody)],
        "rotation": source(floats, rotation_matrices), "start": array_text(applied.start),
    }  # fmt: skip
    return template("forces.py.j2").render(
        code="\n\n".join(_texts(named)), planar=planar, model=list(map(_group, model, model.values())),
        work=list(map(_group, work, work.values())), literal=literal, array=array_text,
        tree=_group("", applied.arrays).removeprefix("=") if isinstance(applied, AppliedForces) else "", **spatial,
    )  # fmt: skip


def motion_text(tree: JointTree) -> str:
    """Return the text of `motion_of(TREE, q, v)`, which gives poses and velocities of a planar tree's coordinates."""
    code = "\n\n".join(_texts(_gathered(motion_of)))
    return f"{code}\n\nTREE = {_group('', arrays_of(tree)).removeprefix('=')}\n"


def plain_text(function: Callable[..., Any]) -> str:
    """Return a function's text without its decorators."""
    lines = inspect.getsource(getattr(function, "py_func", function)).splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("def "))
    return "\n".join(lines[first:]) + "\n"


def array_text(values: Any) -> str:
    """Return NumPy text of an array, to the last bit."""
    array = np.asarray(values)
    whole = ", dtype=int" if array.dtype.kind == "i" else ""
    return f"np.array({literal(array)}{whole})" if array.any() else f"np.zeros({array.shape}{whole})"


def _gathered(*roots: Dispatcher) -> Sources:
    named: Sources = {}
    for root in roots:
        _gather(root, named)
    return named


def _gather(function: Dispatcher, named: Sources) -> None:
    """Add a compiled function and all that it names, directly or not; ValueError where a name means two things."""
    own = function.py_func
    found = {own.__name__: function, **inspect.getclosurevars(own).globals}
    for name, value in found.items():
        if name in named:
            if named[name] is not value:
                raise ValueError(f"name = {name!r} means two things in what {own.__name__} carries")
            continue
        if not isinstance(value, Dispatcher):
            named[name] = value
        elif value.py_func.__name__ == name:
            named[name] = value
            _gather(value, named)


def _texts(named: Sources) -> Iterator[str]:
    """Yield what stands for each name, functions last."""
    for name, value in sorted(named.items(), key=lambda item: isinstance(item[1], Dispatcher)):
        if isinstance(value, Dispatcher):
            yield plain_text(value)
        elif isinstance(value, _Intrinsic):
            yield f'{name} = attrgetter("{name.removesuffix(ACCESSOR)}")' if name.endswith(ACCESSOR) else ""
        elif isinstance(value, type):
            yield f'{name} = namedtuple("{name}", {literal(list(value._fields))})'
        elif not isinstance(value, ModuleType):
            yield f"{name} = {literal(value)}"


def _group(name: str, group: Any) -> str:
    fields = ", ".join(f"{key}={_value(value)}" for key, value in group._asdict().items())
    return f"{name}=SimpleNamespace({fields})"


def _value(value: Any) -> str:
    return array_text(value) if isinstance(value, np.ndarray) else literal(value)
