"""The functions of SUNDIALS that IDA's driver calls, as C has them: no call of the residual passes through Python.

Their prototypes are those of the manual, SUNDIALS 7: sunrealtype is double, sunindextype int64_t and sunbooleantype
int. The Python package's extension holds the library and exports it.
"""

from ctypes import CDLL, POINTER, byref, c_double, c_int, c_int64, c_long, c_void_p, cast
from functools import cache
from typing import Any

_OBJECT, _OBJECT_PLACE = c_void_p, POINTER(c_void_p)
_PROTOTYPES: dict[str, tuple[Any, ...]] = {  # what is returned, then what is taken
    "SUNContext_Create": (c_int, c_int, _OBJECT_PLACE),
    "SUNContext_ClearErrHandlers": (c_int, _OBJECT),
    "SUNContext_Free": (c_int, _OBJECT_PLACE),
    "N_VMake_Serial": (_OBJECT, c_int64, c_void_p, _OBJECT),
    "N_VDestroy": (None, _OBJECT),
    "SUNDenseMatrix": (_OBJECT, c_int64, c_int64, _OBJECT),
    "SUNMatDestroy": (None, _OBJECT),
    "SUNLinSol_Dense": (_OBJECT, _OBJECT, _OBJECT, _OBJECT),
    "SUNLinSolFree": (c_int, _OBJECT),
    "IDACreate": (_OBJECT, _OBJECT),
    "IDAFree": (None, _OBJECT_PLACE),
    "IDAInit": (c_int, _OBJECT, c_void_p, c_double, _OBJECT, _OBJECT),
    "IDASetUserData": (c_int, _OBJECT, c_void_p),
    "IDASVtolerances": (c_int, _OBJECT, c_double, _OBJECT),
    "IDASetId": (c_int, _OBJECT, _OBJECT),
    "IDASetSuppressAlg": (c_int, _OBJECT, c_int),
    "IDASetMaxNumSteps": (c_int, _OBJECT, c_long),
    "IDASetMaxStep": (c_int, _OBJECT, c_double),
    "IDASetNonlinConvCoef": (c_int, _OBJECT, c_double),
    "IDASetLinearSolver": (c_int, _OBJECT, _OBJECT, _OBJECT),
    "IDASetDeltaCjLSetup": (c_int, _OBJECT, c_double),
    "IDAGetDky": (c_int, _OBJECT, c_double, c_int, _OBJECT),
    "IDASetStopTime": (c_int, _OBJECT, c_double),
    "IDASolve": (c_int, _OBJECT, c_double, POINTER(c_double), _OBJECT, _OBJECT, c_int),
    "IDAGetNumErrTestFails": (c_int, _OBJECT, POINTER(c_long)),
}
ONE_STEP = 2  # IDA_ONE_STEP of IDASolve


@cache
def sundials(file: str) -> Any:
    """Return the library in a file, its functions typed; AttributeError names the first that it lacks."""
    library = CDLL(file)
    for name, (returns, *takes) in _PROTOTYPES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = returns, takes
    return library


def address_of(library: Any, name: str) -> int:
    """Return where a function of the library begins."""
    return cast(getattr(library, name), c_void_p).value or 0


def count_of(function: Any, memory: c_void_p) -> int:
    """Return what one of IDA's counters says."""
    count = c_long()
    function(memory, byref(count))
    return count.value
