"""Numbers as a reader meets them: short, with units, never NaN and never blank."""

import math
from functools import partial
from typing import Any

ABSENT = "–"


def short(value: float | None, digits: int = 2) -> str:
    """Return a number with `digits` significant figures, 3.2e-7 rather than 3.2e-07; a dash for None."""
    if value is None or not math.isfinite(value):
        return ABSENT
    value = float(f"{value:.{digits}g}") + 0.0  # which makes 0 of -0
    if value == 0.0 or 1e-2 <= abs(value) < 1e4:
        return f"{value:g}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def with_unit(value: float | None, unit: str) -> str:
    """Return a number with its unit; a dash for None."""
    return ABSENT if value is None or not math.isfinite(value) else f"{short(value)} {unit}"


metres, joules = partial(with_unit, unit="m"), partial(with_unit, unit="J")
closure = partial(with_unit, unit="m, rad")  # of joints: the largest of both


def of_scene(value: float | None) -> str:
    """Return an error over the scene's scales; per cent where it is large."""
    if value is not None and value >= 1e-2:
        return f"{short(100.0 * value)} % of the scene"
    return short(value)


SPANS = (  # s from which a unit reads best, s of the unit, and its name
    (2.0 * 365.25 * 86400.0, 365.25 * 86400.0, "years"), (2.0 * 86400.0, 86400.0, "days"), (7200.0, 3600.0, "h"),
    (600.0, 60.0, "min"), (1.0, 1.0, "s"), (1e-3, 1e-3, "ms"), (0.0, 1e-6, "µs"),
)  # fmt: skip


def duration(seconds: float | None) -> str:
    """Return a time span (s) in the unit that reads best."""
    if seconds is None or not math.isfinite(seconds):
        return ABSENT
    _, size, unit = next((span for span in SPANS if seconds >= span[0]), SPANS[-1])
    return f"{short(seconds / size, 3)} {unit}"


def order_of(observed: float | None, documented: int | None) -> str:
    """Return an observed order beside the documented one, where there is one; empty for None."""
    return "" if observed is None else short(observed) if documented is None else f"{short(observed)} of {documented}"


def count(number: int, noun: str) -> str:
    """Return `1 cell`, `2 cells`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def setting(settings: dict[str, Any]) -> str:
    """Return the accuracy setting of a run in words: h = 0.001 s, or rtol = 1e-9."""
    given = {key: settings.get(key) for key in ("step", "rtol", "atol", "stabilization")}
    words = []
    if given["step"] is not None:
        words.append(f"h = {short(given['step'])} s")
    if given["rtol"] is not None:
        words.append(f"rtol = {short(given['rtol'])}")
    if given["atol"] is not None and given["atol"] != given["rtol"]:
        words.append(f"atol = {short(given['atol'])}")
    if given["stabilization"] is not None:
        words.append(str(given["stabilization"]))
    return ", ".join(words) or "defaults"


def in_words(label: str) -> str:
    """Return the judge's name of a setting, step=0.00201613 or rtol=1e-06, in the format of `setting`."""
    given = dict(part.split("=", 1) for part in label.split(", ") if "=" in part)
    known = all(key in ("step", "rtol", "atol") for key in given)
    return setting({key: float(value) for key, value in given.items()}) if given and known else label
