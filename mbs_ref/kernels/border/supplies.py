"""Functions that each core supplies to kernels that are written once over cores.

A kernel calls a supplied function by its name. Which core's function it is follows from the type of the first argument,
a handle (mbs_ref.kernels.border.handles), when the kernel is compiled: the call costs what any other does. The module
of a handle's class imports all that its core supplies, so that the disk cache knows the sources.
"""

import inspect
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any

from numba.core.extending import _Intrinsic
from numba.core.typing.templates import Signature
from numba.extending import intrinsic

_supplies: dict[type, dict[str, Any]] = {}  # class of a handle -> name -> compiled function


def supply(handles: Iterable[type], interface: ModuleType, modules: Iterable[ModuleType]) -> None:
    """Let the core of these classes of handles supply what `interface` names, each from one of its own modules."""
    own = {name: function for module in modules for name, function in vars(module).items()}
    names = [name for name, stub in vars(interface).items() if isinstance(stub, _Intrinsic)]
    for handle in handles:
        _supplies[handle] = {name: own[name] for name in names}


def supplied(call: str, passes_handle: bool = True) -> Any:
    """Return a supplied function of this name and these parameters, the first of which is a handle.

    Without `passes_handle` that argument chooses the core, and the core's function does not receive it.
    """
    name, _ = parts_of(call)
    return resolved(call, lambda given: _supplies[given[0].instance_class][name], 0 if passes_handle else 1)


def resolved(call: str, choose: Callable[[tuple[Any, ...]], Any], first: int = 0) -> Any:
    """Return a function of this name and these parameters: the one that `choose` returns for their types.

    It receives them from the `first` on.
    """

    def resolve(typingctx, *given):
        function = typingctx.resolve_value_type(choose(given))
        kind = typingctx.resolve_function_type(function, given[first:], {})

        def codegen(context, builder, signature, args):
            implementation = context.get_function(function, kind)
            context.add_linking_libs(getattr(implementation, "libs", ()))
            pairs = zip(args[first:], signature.args[first:], kind.args, strict=True)
            return implementation(builder, [context.cast(builder, *each) for each in pairs])

        return Signature(kind.return_type, given, None), codegen

    return intrinsic_of(call, resolve)


def parts_of(call: str) -> tuple[str, list[str]]:
    """Return the name and the parameters of a call such as "block(model)"."""
    name, _, parameters = call.removesuffix(")").partition("(")
    return name, parameters.split(", ")


def intrinsic_of(call: str, function: Callable[..., Any]) -> Any:
    """Return the intrinsic that a function of the typing context and any arguments defines, as that call names it."""
    function.__name__, parameters = parts_of(call)
    every = [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in ("typingctx", *parameters)]
    function.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
    return intrinsic(function)
