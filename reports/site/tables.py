"""Tables of the documentation, asked of the adapters and of the kept certificates."""

from collections.abc import Iterable, Sequence

from cross_checks.judge.capabilities import Capability, capabilities
from cross_checks.truths.certificate import Certificate, every
from mbs_ref.scene.traits import PART_TYPES

ABSENT = "-"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown; a bar in a cell does not end it."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def capability_page() -> str:
    """Return which parts and scenes every installed engine takes, and why not where it refuses."""
    result = [one for one in capabilities() if one.installed]
    missing = [one for one in capabilities() if not one.installed]
    names = [one.engine for one in result]
    parts = ([f"`{kind}`", *("yes" if one.parts.get(kind) else ABSENT for one in result)] for kind in PART_TYPES)
    scenes = sorted({scene for one in result for scene in one.scenes})
    runs = ([f"`{scene}`", *("yes" if not one.scenes[scene] else ABSENT for one in result)] for scene in scenes)
    methods = ([one.engine, one.version, ", ".join(method.name for method in one.methods)] for one in result)
    return "\n".join(
        [
            "# What each engine can", "Derived from the adapters when these pages were built.\n",
            "## Engines and methods", table(["engine", "version", "methods"], methods),
            *(f"- `{one.engine}`: {one.reason}" for one in missing), "",
            "## Parts", table(["part", *names], parts), "## Scenes as they come", table(["scene", *names], runs),
            "`mbs-ref engines --engine NAME` says why a scene is refused.\n",
        ]
    )  # fmt: skip


def who_can(scene: str, result: Iterable[Capability]) -> str:
    """Return the engines that run a scene."""
    return ", ".join(one.engine for one in result if one.installed and not one.scenes.get(scene, ("unknown",)))


def truth_page() -> str:
    """Return every kept certificate: how well a truth is known, and how that was found."""
    rows = ([_label(one), one.kind, f"{one.uncertainty:.1e}", _confirmed(one), one.how] for one in every())
    head = ["scene", "kind", "known to, m", "our solver within, m", "how"]
    return (
        "# Truths and how well they are known\n\nCertificates of the tree; `mbs-ref certify SCENE` computes one "
        "again and exits with 1 where it differs. Scenes without one get their truth at its first use.\n\n"
        + table(head, rows)
    )


def _label(one: Certificate) -> str:
    return " ".join([f"`{one.scene}`", *(f"{key}={value}" for key, value in one.parameters.items())])


def _confirmed(one: Certificate) -> str:
    return ABSENT if one.confirmed_to is None else f"{one.confirmed_to:.1e}"
