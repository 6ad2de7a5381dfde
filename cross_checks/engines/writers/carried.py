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
from mbs_ref.kernels.answers import ANSWERS, HANDLES
from mbs_ref.kernels.border.supplies import supplied_by
from mbs_ref.kernels.planar.dynamics import load_state as load_planar
from mbs_ref.kernels.rigid import geometry
from mbs_ref.kernels.rigid.loads import rigid_apply_loads
from mbs_ref.kernels.spatial.orientation import load_state as load_spatial
from mbs_ref.scene import SpatialBody, symmetric
from mbs_ref.scene.euler_parameters import floats, rotation_matrices

ACCESSOR = "_of"  # ends the name of what gives a group of arrays of a model or of its scratch
Sources = dict[str, Any]  # what a text names, by its name
NEVER_CALLED = ("call_user",)  # a scene that has a user's own function is refused
_IN_PLANE = (load_planar, rigid_apply_loads, motion_of, project)
_IN_SPACE = (load_spatial, rigid_apply_loads)


def forces_text(applied: AppliedForces | SpatialApplied) -> str:
    """Return the text of `on_bodies(t, ...)`, in the plane also of `generalized(t, q, v)`, as adapters call them."""
    system = applied.system
    planar = isinstance(applied, AppliedForces)
    named = _gathered("planar", *_IN_PLANE) if planar else _gathered("spatial", *_IN_SPACE)
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
    code = "\n\n".join(_texts(_gathered("planar", motion_of)))
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


class _Interface(dict[str, Dispatcher]):
    """What compiled functions call as attributes of `mbs_ref.kernels.rigid.geometry`: the core's functions by name."""


def _gathered(core: str, *roots: Dispatcher) -> Sources:
    answers = {question: answer for group in ANSWERS[core].values() for question, answer in group.items()}
    named: Sources = {}
    for root in roots:
        _gather(root, answers | supplied_by(HANDLES[core][0]), named)
    return named


def _gather(function: Dispatcher, answers: Sources, named: Sources) -> None:
    """Add a compiled function and all that it names, directly or not; a question to the core by the core's answer.

    ValueError where a name means two things, TypeError where what is named has no text.
    """
    own = function.py_func
    found = {own.__name__: function, **inspect.getclosurevars(own).globals}
    for name, value in found.items():
        if value is geometry:
            used = named.setdefault(name, _Interface())
            for attribute in own.__code__.co_names:
                if attribute in vars(geometry) and attribute not in used:
                    used[attribute] = answers[attribute]
                    _gather(answers[attribute], answers, named)
            continue
        meant = answers[name] if isinstance(value, _Intrinsic) and name in answers else value
        if name in named:
            if named[name] is not meant:
                raise ValueError(f"name = {name!r} means two things in what {own.__name__} carries")
            continue
        named[name] = meant
        if isinstance(meant, Dispatcher):
            _gather(meant, answers, named)
        elif isinstance(meant, _Intrinsic) and not name.endswith(ACCESSOR) and name not in NEVER_CALLED:
            raise TypeError(f"{name} of {own.__name__} is no Python text, and no question that the core answers")


def _texts(named: Sources) -> Iterator[str]:
    """Yield what stands for each name: data, functions, then other names of these."""
    called = [value for value in named.values() if isinstance(value, Dispatcher)]
    for name, value in named.items():
        if isinstance(value, _Intrinsic) and name.endswith(ACCESSOR):
            yield f'{name} = attrgetter("{name.removesuffix(ACCESSOR)}")'
        elif isinstance(value, type):
            yield f'{name} = namedtuple("{name}", {literal(list(value._fields))})'  # pyright: ignore[reportAttributeAccessIssue]
        elif not isinstance(value, ModuleType | Dispatcher | _Intrinsic | _Interface):
            yield f"{name} = {literal(value)}"
    yield from map(plain_text, dict.fromkeys(called))
    yield from (_interface_text(name, value) for name, value in named.items() if isinstance(value, _Interface))
    others = {name: value.py_func.__name__ for name, value in named.items() if isinstance(value, Dispatcher)}
    yield from (f"{name} = {own}" for name, own in others.items() if name != own)


def _interface_text(name: str, functions: _Interface) -> str:
    """Return a namespace of functions; those that do not receive the handle that chooses the core drop it."""
    calls = (f"{own}={own if getattr(geometry, own).passes_handle else f'lambda work, *given: {own}(*given)'}"
             for own in functions)  # fmt: skip
    return f"{name} = SimpleNamespace({', '.join(calls)})"


def _group(name: str, group: Any) -> str:
    fields = ", ".join(f"{key}={_value(value)}" for key, value in group._asdict().items())
    return f"{name}=SimpleNamespace({fields})"


def _value(value: Any) -> str:
    return array_text(value) if isinstance(value, np.ndarray) else literal(value)
