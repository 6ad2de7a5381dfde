"""Questions: functions that compiled code calls by address, without linking their code.

Numba links the code of every callee into each caller's library and optimises it there again. Some forty functions
contain the whole dynamics somewhere below them, so a new user once waited for minutes. A question is a border in that
graph: its answer is compiled once, and whoever asks calls the address that the handle (handles.py) holds
for it. So what lies above a border knows no core: an integrator is compiled once for all of them, and a scene pays
for its own core alone. It costs a load and a call that is never inlined, a few nanoseconds, and nothing is
contracted or hoisted across it. Addresses live in memory only; what the disk cache holds does not depend on them.
"""

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import signature

from mbs_ref.kernels.algebra.lanes import LANES, holds_lanes
from mbs_ref.kernels.border.handles import QUESTIONS, Model, Work, is_handle
from mbs_ref.kernels.border.supplies import intrinsic_of, parts_of
from mbs_ref.kernels.jit import jit

MODEL, WORK = (types.NamedUniTuple(types.int64, 1, kind) for kind in (Model, Work))
NOTHING, NUMBER, COUNT, FLAG = types.none, types.float64, types.int64, types.boolean
NUMBERS, COUNTS = types.UniTuple(NUMBER, 2), types.UniTuple(COUNT, 2)
VECTOR, MATRIX = (types.Array(types.float64, dimension, "C") for dimension in (1, 2))
_NAMES = {  # of the parameters of each type
    MODEL: "model",
    WORK: "work",
    NUMBER: "t tolerance factor duration span",
    COUNT: "most slot row k",
    FLAG: "velocity_level located",
    VECTOR: "y dy x g out rate balance move moved",
    MATRIX: "lam gamma table forces slips",
}
KINDS = {name: kind for kind, names in _NAMES.items() for name in names.split()}

# What handles in lanes have in place of floats.
IN_LANES: dict[Any, Any] = {
    NUMBER: LANES, NUMBERS: types.UniTuple(LANES, 2), VECTOR: types.Array(LANES, 1, "C"),
    MATRIX: types.Array(LANES, 2, "C"),
}  # fmt: skip

_asked: dict[str, tuple[int, Any]] = {}  # question -> place of its address in a handle, signature


def question(call: str, returns: Any = NOTHING) -> Any:
    """Return a question of this name and these parameters, whose names state their types; the first is a handle.

    Arrays are handed over as they are: one that is not C-contiguous is refused where the asking code is typed.
    """
    name, parameters = parts_of(call)
    takes = [KINDS[parameter] for parameter in parameters]
    place = len(_asked)
    if place == QUESTIONS:
        raise ValueError(f"a handle has room for {QUESTIONS} questions")
    _asked[name] = place, signature(returns, *takes)

    def ask(typingctx, *given):
        kinds = IN_LANES if holds_lanes(given[0]) else {}
        taken = [kinds.get(kind, kind) for kind in takes]
        if not all(map(partial(_fits, typingctx), given, taken)):
            return None
        own = (g if is_handle(g) else t for g, t in zip(given, taken, strict=True))
        return signature(kinds.get(returns, returns), *own), _call(place)

    return intrinsic_of(call, ask)


def _fits(typingctx: Any, given: Any, taken: Any) -> bool:
    if is_handle(given):
        return is_handle(taken)
    kind = typingctx.can_convert(given, taken)
    return kind is not None and kind <= Conversion.safe


def _call(place: int) -> Callable[..., Any]:
    """Return what emits the call of the answer at a place of the first argument's handle."""

    def codegen(context, builder, kind, args):
        handle = builder.inttoptr(builder.extract_value(args[0], 0), ir.IntType(64).as_pointer())
        address = builder.load(cgutils.gep_inbounds(builder, handle, place))
        return _call_at(context, builder, signature(kind.return_type, types.int64, *kind.args), [address, *args])

    return codegen


def _call_at(context: Any, builder: Any, kind: Any, args: Any) -> Any:
    """Emit the call of the code at the first argument, an address."""
    takes, function = kind.args[1:], context.call_conv.get_function_type(kind.return_type, kind.args[1:])
    callee = builder.inttoptr(args[0], function.as_pointer())
    status, answer = context.call_conv.call_function(builder, callee, kind.return_type, takes, args[1:])
    with cgutils.if_unlikely(builder, status.is_error):
        context.call_conv.return_status_propagate(builder, status)
    return answer


def called_at(call: str, returns: Any, *takes: Any) -> Any:
    """Return a function of this name and these parameters, the first of which is the address of the code that it calls.

    That code takes the types `takes`; `address_of` returns where it begins.
    """

    def ask(typingctx, _address, *given):
        fits = all(map(partial(_fits, typingctx), given, takes))
        return (signature(returns, types.int64, *takes), _call_at) if fits else None

    return intrinsic_of(call, ask)


@jit
def _unanswered():
    raise RuntimeError("a question was asked that this system was not prepared for (System.prepare)")


def address_of(answer: Any, kind: Any) -> int:
    """Return where the code of a function of this signature begins; compile or load it if need be."""
    answer.compile(kind)
    compiled = answer.overloads[kind.args]
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)


@cache
def unanswered() -> np.ndarray:
    """Return the first words of a handle by which every question raises a RuntimeError.

    One function without arguments will do for all of them: it is the caller that clears the stack.
    """
    return np.full(QUESTIONS, address_of(_unanswered, signature(types.none)))


def addresses(answers: Mapping[str, Any], model: type, work: type) -> tuple[np.ndarray, np.ndarray]:
    """Return the places in a handle of these questions, and the addresses of the functions that answer them.

    The functions are compiled for a core's own classes of handles, which are numbers as those of the questions are.
    """
    own = {MODEL: types.NamedUniTuple(types.int64, 1, model), WORK: types.NamedUniTuple(types.int64, 1, work)}
    own |= IN_LANES if holds_lanes(own[MODEL]) else {}
    rows = []
    for name, answer in answers.items():
        place, kind = _asked[name]
        rows.append((place, address_of(answer, signature(*(own.get(x, x) for x in (kind.return_type, *kind.args))))))
    places, where = np.array(rows, dtype=np.int64).reshape(-1, 2).T
    return places, where


def _call_of_c(call: str, returns: Any, *takes: Any) -> Any:
    """Return a function of this name whose first argument is where C code begins; it calls that with the others."""

    def typed(typingctx, *given):
        def codegen(context, builder, kind, args):
            back = ir.VoidType() if returns == NOTHING else context.get_value_type(returns)
            function = ir.FunctionType(back, [context.get_value_type(taken) for taken in takes])
            answer = builder.call(builder.inttoptr(args[0], function.as_pointer()), args[1:])
            return context.get_dummy_value() if returns == NOTHING else answer

        return returns(types.int64, *takes), codegen

    return intrinsic_of(call, typed)


# Call void (double t, double *data) with the time and the address of data, or 0.
call_user = _call_of_c("call_user(address, t, data)", NOTHING, NUMBER, types.uintp)
# Call double *(void *thing) and return the pointer to its numbers.
call_for_numbers = _call_of_c("call_for_numbers(address, thing)", types.CPointer(NUMBER), types.intp)
