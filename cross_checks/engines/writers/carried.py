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
from cross_checks.linkage.forces import Applied, planar_wrenches, spatial_wrenches
from cross_checks.linkage.motion import LinkArrays, motion_of, project
from mbs_ref.kernels.answers import ANSWERS
from mbs_ref.scene.euler_parameters import conjugate, floats, parameter_matrix, product

ACCESSOR = "_of"  # ends the name of what gives a group of arrays of a model or of its scratch
Sources = dict[str, Any]  # what a text names, by its name
OF_KINEMATICS = ("force", "inertia", "omega")  # arrays that the core writes to and the sum of forces reads
NEVER_CALLED = ("call_user",)  # a scene that has a user's own function is refused


def forces_text(applied: Applied) -> str:
    """Return the text of MOTION, and of FORCES, which has the methods of the adapters' Applied."""
    system = applied.system
    core, root = ("planar", planar_wrenches) if applied.planar else ("spatial", spatial_wrenches)
    named = _gathered(core, root)
    groups = [name.removesuffix(ACCESSOR) for name, value in named.items() if isinstance(value, _Intrinsic)]
    model = {name: getattr(system.groups, name) for name in groups if hasattr(system.groups, name)}
    work = {name: getattr(system.scratch, name) for name in groups if hasattr(system.scratch, name)}
    shared = {name: f"WORK.kinematics.{name}" for name in (("force",) if applied.planar else OF_KINEMATICS)}
    own = {key: shared.get(key) or _value(value) for key, value in applied.core._asdict().items()}
    return motion_text(applied.tree) + template("forces.py.j2").render(
        code="\n\n".join(_texts(named)), core=core, own=", ".join(f"{key}={value}" for key, value in own.items()),
        parameters=source(floats, conjugate, product, parameter_matrix),
        model=list(map(_group, model, model.values())), work=list(map(_group, work, work.values())),
    )  # fmt: skip


def motion_text(tree: LinkArrays) -> str:
    """Return the text of MOTION, whose `motion_of` and `project` are those of the adapters over one linkage."""
    code = "\n\n".join(_texts(_gathered("spatial", motion_of, project)))
    return template("motion.py.j2").render(code=code, tree=_group("", tree).removeprefix("="))


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


def _gathered(core: str, *roots: Dispatcher) -> Sources:
    answers = {question: answer for group in ANSWERS[core].values() for question, answer in group.items()}
    named: Sources = {}
    for root in roots:
        _gather(root, answers, named)
    return named


def _gather(function: Dispatcher, answers: Sources, named: Sources) -> None:
    """Add a compiled function and all that it names, directly or not; a question to the core by the core's answer.

    ValueError where a name means two things, TypeError where what is named has no text.
    """
    own = function.py_func
    found = {own.__name__: function, **inspect.getclosurevars(own).globals}
    for name, value in found.items():
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
        elif not isinstance(value, ModuleType | Dispatcher | _Intrinsic):
            yield f"{name} = {literal(value)}"
    yield from map(plain_text, dict.fromkeys(called))
    others = {name: value.py_func.__name__ for name, value in named.items() if isinstance(value, Dispatcher)}
    yield from (f"{name} = {own}" for name, own in others.items() if name != own)


def _group(name: str, group: Any) -> str:
    fields = ", ".join(f"{key}={_value(value)}" for key, value in group._asdict().items())
    return f"{name}=SimpleNamespace({fields})"


def _value(value: Any) -> str:
    return array_text(value) if isinstance(value, np.ndarray) else literal(value)
