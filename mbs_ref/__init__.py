"""mbs-ref's language of scenes and its own solver.

    import mbs_ref
    scene = mbs_ref.scenes.make("pendulum")
    path = mbs_ref.simulate(scene, mbs_ref.Settings(rtol=1e-9))

The public names are listed in `__init__.pyi`. They are imported when they are first used.
"""

import sys

from mbs_ref.public_names import offer

if sys.platform != "linux":  # processor affinity, file locks and /proc are Linux's
    raise ImportError(f"mbs-ref needs Linux, and this system is {sys.platform}: use a container or WSL")
offer(__name__, __file__)
