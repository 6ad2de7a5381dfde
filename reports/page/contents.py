"""The page's sections, in the order in which they are read."""

from __future__ import annotations

from reports.page.section import Section
from reports.page.sections import (
    capabilities,
    compliance,
    convergence,
    energy,
    environment,
    extremes,
    findings,
    matrix,
    profiles,
    records,
    time_split,
    truths,
    verdict,
    work_precision,
)
from reports.studies.androids import section as androids
from reports.studies.contact import section as contact
from reports.studies.crashes import section as crashes
from reports.studies.sky import section as sky
from reports.studies.space import section as space

SECTIONS: tuple[Section, ...] = tuple(
    module.SECTION
    for module in (
        verdict, matrix, extremes, findings, work_precision, compliance, convergence, energy, time_split, profiles,
        sky, space, contact, crashes, androids, capabilities, truths, environment, records,
    )
)  # fmt: skip
