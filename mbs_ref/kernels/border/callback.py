"""Call C functions by address from compiled code."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def call_user(typingctx: Any, address: Any, t: Any, data: Any) -> Any:
    """Call void (double t, double *data) at `address` with the time and the address of data, or 0."""
    signature = types.void(types.int64, types.float64, types.uintp)

    def codegen(context, builder, signature, args):
        word = ir.IntType(64)
        function_type = ir.FunctionType(ir.VoidType(), [ir.DoubleType(), word])
        pointer = builder.inttoptr(args[0], function_type.as_pointer())
        builder.call(pointer, [args[1], args[2]])
        return context.get_dummy_value()

    return signature, codegen


@intrinsic
def call_for_numbers(typingctx: Any, address: Any, thing: Any) -> Any:
    """Call double *(void *thing) at `address` and return the pointer to its numbers."""
    numbers = types.CPointer(types.float64)
    signature = numbers(types.int64, types.intp)

    def codegen(context, builder, signature, args):
        word = ir.IntType(64)
        function_type = ir.FunctionType(context.get_value_type(numbers), [word])
        return builder.call(builder.inttoptr(args[0], function_type.as_pointer()), [args[1]])

    return signature, codegen
