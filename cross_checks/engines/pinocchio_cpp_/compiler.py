"""The C++ program, compiled once against Pinocchio's own wheel.

The engine takes its algorithm from the library, compiled for any processor. Benchmarks compile all algorithms from
the headers alone for this processor, which takes minutes. Programs are stored in the cache folder under a digest of
source, compiler, flags, processor and Pinocchio's version.
"""

import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

import pinocchio as pin
from llvmlite.binding import get_host_cpu_name
from numba.core.event import trigger_event

from mbs_ref.kernels.jit import cache_folder

SOURCE = Path(__file__).with_name("driver.cpp")
COMPILERS = ("g++", "clang++")  # tried in turn where the environment names none in CXX
LIBRARY = "libpinocchio_default.so"
# The definitions with which the wheel's own CMake files compile against it (pinocchioTargets.cmake).
FLAGS = (
    "-std=c++17", "-O3", "-w", "-DNDEBUG", "-fPIC", "-shared", "-fvisibility=hidden",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)  # fmt: skip
LINKED = ("-DPINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION", "-lpinocchio_default")
NATIVE = ("-march=native", "-DEVERY_ALGORITHM")


@cache
def obstacle() -> str:
    """Return why the program cannot be compiled here; empty where it can."""
    if _compiler() is None:
        return f"no C++ compiler was found: {', '.join(COMPILERS)}, or what CXX names"
    needed = {"Pinocchio's headers": _prefix() / "include" / "pinocchio" / "multibody.hpp",
              "Boost's headers": _prefix() / "include" / "boost" / "variant.hpp",
              "Eigen's headers (package cmeel-eigen)": _prefix() / "include" / "eigen3" / "Eigen" / "Core",
              "Pinocchio's library": _prefix() / "lib" / LIBRARY}  # fmt: skip
    missing = [name for name, path in needed.items() if not path.is_file()]
    return f"the installation of Pinocchio lacks {', '.join(missing)}" if missing else ""


@cache
def described(every: bool = False) -> str:
    """Return Pinocchio's version, the compiler's, the build, and a digest of the program's source."""
    program = hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:8]
    build = f"headers alone, -march=native on {get_host_cpu_name()}" if every else "the wheel's library"
    return f"{pin.__version__}, {build}, {_compiler_version()}, program {program}"


def library(every: bool = False) -> Path:
    """Return the program, with every algorithm or one; compiled where it is not stored.

    Raises RuntimeError with the compiler's message.
    """
    flags = NATIVE if every else LINKED
    parts = described(every), FLAGS, flags, platform.machine(), str(_prefix())
    name = hashlib.sha256(repr(parts).encode()).hexdigest()[:20]
    kept = cache_folder() / f"pinocchio_cpp-{name}.so"
    if not kept.is_file():
        with trigger_event("numba:compile"):  # who waits for a run sees that it compiles
            _compile(kept, flags)
    return kept


def _compile(kept: Path, flags: tuple[str, ...]) -> None:
    """Compile to a temporary file and rename it, so that no process loads an incomplete library."""
    kept.parent.mkdir(parents=True, exist_ok=True)
    handle, made = tempfile.mkstemp(suffix=".so", dir=kept.parent)
    os.close(handle)
    include, lib = _prefix() / "include", _prefix() / "lib"
    where = ["-isystem", include, "-isystem", include / "eigen3", f"-L{lib}", f"-Wl,-rpath,{lib}"]
    command = [_compiler(), *FLAGS, *where, SOURCE, *flags, "-o", made, "-lboost_serialization"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        os.unlink(made)
        raise RuntimeError(f"{_compiler()} could not compile {SOURCE.name}: {done.stderr[-2000:]}")
    os.replace(made, kept)


def _compiler() -> str | None:
    named = os.environ.get("CXX")
    return next((path for name in ((named,) if named else COMPILERS) if (path := shutil.which(name))), None)


def _compiler_version() -> str:
    compiler = _compiler()
    if compiler is None:
        return "no compiler"
    version = subprocess.run([compiler, "-dumpfullversion", "-dumpversion"], capture_output=True, text=True).stdout
    return f"{compiler.rsplit(os.sep, 1)[-1]} {version.strip()}"


@cache
def _prefix() -> Path:
    """Return the folder with include/ and lib/ that Pinocchio's wheels share."""
    try:
        found = next(file for file in files("libpinocchio") or () if file.name == LIBRARY)
    except (PackageNotFoundError, StopIteration):
        return Path(pin.__path__[0]).parents[3]  # not from wheels: <prefix>/lib/python3.x/site-packages/pinocchio
    return Path(str(found.locate())).parents[1]
