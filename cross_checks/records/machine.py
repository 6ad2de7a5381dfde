"""The machine that runs are timed on, and when a run had a processor of it to itself."""

import platform
from functools import cache
from pathlib import Path

BUSY = 0.9  # of a processor: with less, a run shares the machine
WARMED = 0.2  # s of loop time: warming caches up is a small part of a longer run, which counts
CPU_FACTS = Path("/proc/cpuinfo")  # Linux; elsewhere the platform module knows


def processor() -> str:
    """Return the processor's name."""
    lines = CPU_FACTS.read_text().splitlines() if CPU_FACTS.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next(iter(models), platform.processor() or platform.machine())


@cache
def machine() -> str:
    """Return what times compare on: the computer and its processor."""
    return f"{platform.node()} {processor()}"
