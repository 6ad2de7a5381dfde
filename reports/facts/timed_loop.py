"""What lies inside each engine's timed loop, stated beside every time."""

from __future__ import annotations

INSIDE = {
    "mbs_ref": "compiled loop; the check of the start, and the error estimate of a judged run, lie outside",
    "exudyn": "its own C++ loop, one call a run for a fixed step, with modified Newton; "
    "forces that it lacks come through Python callbacks inside the loop",
    "mujoco": "mj_step in C, called from Python once an output, where its warnings are read; "
    "forces that it lacks come through callbacks inside the loop",
    "pinocchio": "its C++ dynamics called from Python at every stage: the calls are inside the loop; "
    "only breakpoints restart its adaptive method",
    "pinocchio_cpp": "its C++ dynamics in a C++ loop of ours, compiled here against the headers of its wheel; "
    "one call a run",
    "rebound": "its own C loop; additional forces are compiled",
    "drake": "Simulator.AdvanceTo in C++, called from Python once an output; "
    "forces that it lacks come through a Python system inside the loop",
    "dart": "World.step in C++, called from Python once a step, as its users do",
    "mjx": "one compiled call an output; compiling it, which takes seconds, is counted as the first call",
    "opensim": "Manager.integrate in C++, called from Python once an output",
    "basilisk": "fixed steps by its scheduler in C++; adaptive ones by one call of the spacecraft an output",
    "newton": "a recorded step, replayed by Warp in C++, called from Python once a step; "
    "compiling and recording it are counted as the first call",
    "heyoka": "its own compiled loop; compiling the Taylor series is counted as building the model",
}
