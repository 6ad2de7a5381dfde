"""Engines behind one contract, truths, and the verdicts on runs.

    import cross_checks
    run = cross_checks.run(scene, "mujoco", step=1e-3)

The public names are listed in `__init__.pyi`. They are imported when they are first used.
"""

from mbs_ref.public_names import offer

offer(__name__, __file__)
