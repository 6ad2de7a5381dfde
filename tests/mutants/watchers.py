"""Which tests ought to notice a defect in which sources: the nearest and quickest first."""

from __future__ import annotations

SKY = ("tests/cross_checks/truths/test_sky_forces.py", "tests/mbs_ref/cores/test_particles.py",
       "tests/cross_checks/truths/test_sky_truths.py")  # fmt: skip
AIR = ("tests/cross_checks/truths/test_against_us1976.py", *SKY)
ALONE = ("tests/mbs_ref/kernels/test_small_algebra.py", "tests/mbs_ref/kernels/contact/test_laws_alone.py",
         "tests/mbs_ref/kernels/test_closed_forms.py")  # fmt: skip
CONTACT = ("tests/mbs_ref/kernels/contact/test_near_pairs.py", *ALONE, "tests/mbs_ref/kernels/contact")
PLANE = (*ALONE, "tests/mbs_ref/kernels", "tests/mbs_ref/cores/test_planar.py",
         "tests/mbs_ref/cores/test_random_scenes.py")  # fmt: skip
SPACE = (*ALONE, "tests/mbs_ref/kernels", "tests/mbs_ref/cores/test_spatial.py",
         "tests/mbs_ref/cores/test_random_scenes.py")  # fmt: skip
RUNS = ("tests/mbs_ref/integrators/test_parts_alone.py", "tests/mbs_ref/integrators/test_radau_alone.py",
        "tests/mbs_ref/integrators", "tests/mbs_ref/simulate", "tests/mbs_ref/kernels/contact",
        "tests/mbs_ref/cores")  # fmt: skip
CRASH = ("tests/mbs_ref/crash/test_against_injury_vectors.py", "tests/mbs_ref/crash/test_measures_alone.py",
         "tests/mbs_ref/crash", "tests/reports/studies/test_android_page.py")  # fmt: skip
SIMULATE = ("tests/mbs_ref/simulate/start/test_ambiguous_start.py", "tests/mbs_ref/simulate",
            "tests/mbs_ref/cores/test_spatial.py")  # fmt: skip
TRUTHS = ("tests/cross_checks/truths",)
ENGINES = (
    "tests/cross_checks/engines",
    "tests/cross_checks/engine",
    "tests/cross_checks/linkage",
    "tests/cross_checks/conformance/symmetry",
)
JUDGE = ("tests/cross_checks/judge", "tests/cross_checks/records", "tests/cross_checks/truths/test_sky_truths.py")

# the longest prefix of a defect's file decides
WATCHERS: dict[str, tuple[str, ...]] = {
    "benchmarks": ("tests/benchmarks",),
    "reports": (
        "tests/reports/commands/test_figures_of_commands.py",
        "tests/reports/studies/test_more_figures.py",
        "tests/reports/page/test_recomputed_pages.py",
        "tests/reports/page",
        "tests/reports",
    ),
    "reports/commands": ("tests/reports/commands/test_every_table.py", "tests/reports/commands", "tests/reports"),
    "mbs_ref": ("tests/mbs_ref",),
    "mbs_ref/kernels": (*PLANE, "tests/mbs_ref/cores/test_spatial.py"),
    "mbs_ref/kernels/particles": SKY,
    "mbs_ref/kernels/particles/satellites": AIR,
    "mbs_ref/kernels/planar": PLANE,
    "mbs_ref/kernels/spatial": SPACE,
    "mbs_ref/kernels/rigid": ("tests/mbs_ref/cores/test_loops.py", *PLANE, *SPACE),
    "mbs_ref/kernels/contact": CONTACT,
    "mbs_ref/cores/particles": SKY,
    "mbs_ref/integrators": RUNS,
    "mbs_ref/crash": CRASH,
    "mbs_ref/observables": ("tests/mbs_ref/observables", *CRASH, *CONTACT, "tests/mbs_ref/cores"),
    "mbs_ref/simulate": SIMULATE,
    "mbs_ref/simulate/many/ensemble": ("tests/mbs_ref/simulate/many/ensemble",),
    "mbs_ref/simulate/linearised": ("tests/mbs_ref/kernels/contact/test_contact.py", *SIMULATE),
    "cross_checks": ("tests/cross_checks",),
    "cross_checks/certify": TRUTHS,
    "cross_checks/prices": ("tests/benchmarks",),
    "cross_checks/robots": ("tests/cross_checks/robots",),
    "cross_checks/writers": ("tests/cross_checks/writers",),
    "cross_checks/truths/made_by": TRUTHS,
    "cross_checks/truths/made_by/numerics/collocation": SKY[::-2],
    "cross_checks/truths/made_by/sky/particles": SKY[::-2],
    "cross_checks/truths/made_by/sky": SKY[:1],
    "cross_checks/truths/made_by/sky/satellites": (*SKY[:1], *AIR[:1]),
    "cross_checks/truths": (*TRUTHS, "tests/mbs_ref/kernels/contact"),  # whose runs are held against truths
    "cross_checks/engines": ENGINES,
    "cross_checks/engines/rebound": ("tests/cross_checks/engines/test_engine_sky.py", *ENGINES),
    "cross_checks/engine": ("tests/cross_checks/engine", *ENGINES),
    "cross_checks/linkage": ("tests/cross_checks/linkage", *ENGINES),
    "cross_checks/judge": JUDGE,
    "cross_checks/records": ("tests/cross_checks/records", "tests/reports/page", "tests/reports/test_keys.py", *JUDGE),
    "cross_checks/trajectory_files": ("tests/cross_checks/trajectory_files",),
    "cross_checks/metrics": ("tests/cross_checks/metrics", *JUDGE, "tests/cross_checks/engines"),
    "cross_checks/metrics/contact_figures": ("tests/cross_checks/truths/test_contact_truths.py", *JUDGE),
    "cross_checks/contact": ("tests/cross_checks/contact",),
    "cross_checks/conformance": (
        "tests/cross_checks/conformance/test_clocks.py",
        "tests/cross_checks/conformance/test_figures_alone.py",
        "tests/cross_checks/conformance/test_probes_alone.py",
        "tests/cross_checks/conformance",
        "tests/benchmarks/test_repeatability.py",
    ),
    "cross_checks/conformance/symmetry": ("tests/cross_checks/conformance/symmetry",),
}


def tests_for(file: str) -> tuple[str, ...]:
    """Return test files and folders, in the order to run them."""
    prefix = max((p for p in WATCHERS if file.startswith(p)), key=len)
    return tuple(dict.fromkeys(WATCHERS[prefix]))
