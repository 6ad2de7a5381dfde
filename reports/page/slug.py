"""Names of the report's files."""

from __future__ import annotations

import hashlib
import re

LONGEST = 80


def slug(text: str) -> str:
    """Return a file name without markup; two texts that differ in what was dropped differ by a digest."""
    plain = re.sub(r"[^\w.+=-]+", "-", text).strip("-")[:LONGEST]
    kept = plain.replace("-", " ") == text
    return plain if kept else f"{plain}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def scene_file(label: str) -> str:
    return f"scene-{slug(label)}.html"


def engine_file(name: str) -> str:
    return f"engine-{slug(name)}.html"
