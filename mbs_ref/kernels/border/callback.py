"""Call a C callback by address from compiled code: void (double t, double *q_v_f)."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def call_user_force(typingctx: Any, address: Any, t: Any, data: Any) -> Any:
    """Call the function at `address` with the time and the address of the (3, n, 3) array q, v, f."""
    signature = types.void(types.int64, types.float64, types.uintp)

    def codegen(context, builder, signature, args):
        word = ir.IntType(64)
        function_type = ir.FunctionType(ir.VoidType(), [ir.DoubleType(), word])
        pointer = builder.inttoptr(args[0], function_type.as_pointer())
        builder.call(pointer, [args[1], args[2]])
        return context.get_dummy_value()

    return signature, codegen
