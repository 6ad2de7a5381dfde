"""Trust: nothing is measured; the section shows tables of the tree."""

from __future__ import annotations

from reports.studies.study import Study

STUDY = Study("trust.html", "Trust in the error estimates")
