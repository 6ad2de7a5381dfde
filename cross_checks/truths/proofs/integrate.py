"""The prover: it proposes a polynomial for every step and lets the checker's bounds decide; the log has what holds."""

import math
import time
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_poly, arb_series  # pyright: ignore[reportMissingImports]  # an optional extra
from scipy.linalg import pascal

from cross_checks.truths.proofs.checker.bounds import ORDER, Step, variations
from cross_checks.truths.proofs.checker.formulas import (
    GAMMA,
    Formulas,
    Polynomials,
    Refused,
    beside,
    exact,
    precision,
    terms,
)  # fmt: skip
from cross_checks.truths.proofs.checker.proof import Proof
from cross_checks.truths.proofs.derivation import READINGS, Units
from cross_checks.truths.proofs.equations import derive
from cross_checks.truths.proofs.family import family
from mbs_ref import Scene
from mbs_ref.scene.scales import scales_of

SAMPLES = 32  # of a step, at which gaps are evaluated
TOUCHES = 12  # iterations of Newton's method for the time
MARGIN = 1.5  # of the time that the box takes to pass, which the window lasts
DEGREE, DIGITS = 40, 36  # of the polynomials, at least; a step's defect is about SAFETY^-DEGREE
DIGITS_PROVEN = 20.0  # of a radius, that DEGREE and DIGITS reach in most motions
SAFETY = 5.5  # steps in a radius of convergence
SHORTER, ATTEMPTS = Fraction(5, 7), 12  # a step that is not proven is tried again so much shorter, so often
SHORTEST = Fraction(1, 1 << 16)  # of the duration: a step below which no shorter one is tried
LONGER = 1.05  # how much longer a step may be than the last proven one, of the radius of convergence
WIDER, WIDENED = 8, 4  # times so much an impact's window in the next attempt; attempts before a shorter step
HALVINGS = 4  # of a parameter's interval, at most
ROUGH_BITS = 64  # of the polynomials that state the unit of time
LATER = pascal(ORDER, "upper")  # times a series of ORDER terms: the series about the end of its unit of time
FINEST, MORE_DIGITS = 3, (1.1, 2.5)  # attempts at a radius, each with so many times the digits of the last


def first_touch(proof: Proof, h: Fraction, rows: list[list[int]], wider: float) -> tuple[Fraction, Fraction] | None:
    """Return a step's length up to the end of its first impact, and the share of its window; None without one.

    Both are hints, which the checker proves.
    """
    n, still = proof.n, np.zeros(proof.n)
    with precision(proof.bits + 32):
        p = [[arb((int(c), -proof.bits)) for c in row] for row in rows]

        def gap(part: int, s: arb, e: np.ndarray = still) -> list[arb]:
            return proof.impacts.gap(part, beside(p[:n], e, s))

        instants, parts = (exact(Fraction(k, SAMPLES)) for k in range(1, SAMPLES + 1)), range(len(proof.impacts.names))
        closed = next((own for s in instants if (own := [(k, s) for k in parts if gap(k, s)[0] < 0])), [])
        touches = []
        for part, s in closed:
            for _ in range(TOUCHES):
                apart, rate = gap(part, s)
                s = (s - apart / (rate * exact(h))).mid()
            touches.append((float(s), s, part, abs(float(rate)) * float(h)))
        if not touches:
            return None
        _, s, part, rate = min(touches, key=lambda one: one[0])
        flow = variations(Step(proof.formulas, h, p).slopes()[0], np.eye(n), np.zeros((ORDER, len(p), n)))[:, :n]
        flow = np.tensordot(float(s) ** np.arange(ORDER), flow, 1)
        wide = np.abs(flow @ proof.moved) @ proof.box + np.abs(flow) @ proof.loose + GAMMA * proof.box.max()
        spread = wider * (float(gap(part, s, wide)[0].rad()) + 2.0 ** -(proof.bits - 16))
        mantissa, exponent = s.man_exp()
        end = Fraction(int(mantissa)) * Fraction(2) ** int(exponent) + Fraction(MARGIN * spread / rate)
        return h * end, Fraction(2 * MARGIN * spread / rate) / end


class Proven(NamedTuple):
    """A motion's proof, or how far it reaches; the log has its seconds and the reason why it ends before the end."""

    log: dict[str, Any]
    proof: Proof


def prove(
    scene: Scene, times: Sequence[float], aim: float = 1e-15, inputs: str = "binary64",
    limit: float = math.inf, report: Callable[[float, float], None] = lambda t, radius: None,
    ends: tuple[Scene, Scene] | None = None,
) -> Proven:  # fmt: skip
    """Return a proof at `times` (s, increasing from 0) with a radius below `aim`, or how far it reaches.

    `report` receives the time reached (s) and the radius; `limit` is processor time (s). Raises NotCovered, and Refused
    where the start or the formulas are not the scene's. With `ends`, the whole `family` is enclosed.
    """
    began, last, factor = time.process_time(), None, max(1.0, -math.log10(aim) / DIGITS_PROVEN)
    for attempt in reversed(range(FINEST)):
        left, bound = limit - (time.process_time() - began), aim if attempt else math.inf
        last = _attempt(scene, times, inputs, int(DEGREE * factor), int(DIGITS * factor), bound, left, report, ends)
        if ends or last.proof.radius <= aim or "limit" in last.log["reason"]:
            break
        defect = math.log10(SAFETY) * DEGREE  # digits, times the factor
        grown = math.log10(last.proof.radius) + defect * factor  # digits, until the time reached
        wanted = (grown * times[-1] / last.proof.reached - math.log10(aim)) / defect
        factor *= min(MORE_DIGITS[1], max(MORE_DIGITS[0], wanted / factor))
    assert last is not None
    last.log["seconds"] = time.process_time() - began
    return last


def prove_family(
    make: Callable[[float], Scene], low: float, high: float, times: Sequence[float], inputs: str = "binary64",
    limit: float = math.inf, report: Callable[[float, float], None] = lambda t, radius: None,
) -> list[Proven]:  # fmt: skip
    """Return proofs of all scenes that `make` returns for a parameter from low to high.

    A part of the interval that does not reach the last time is halved, while the `limit` lasts.
    """
    began, proofs, parts = time.process_time(), [], [(low, high, HALVINGS)]
    while parts:
        a, b, halvings = parts.pop()
        left, middle = began + limit - time.process_time(), 0.5 * (a + b)
        one = prove(make(middle), times, math.inf, inputs, left, report, (make(a), make(b)))
        if one.log["reason"] and halvings and time.process_time() - began < limit:
            parts += [(middle, b, halvings - 1), (a, middle, halvings - 1)]
            continue
        if one.log["reason"]:
            one.log["reason"] += f" (parameter from {a!r} to {b!r})"
        proofs.append(one)
    return proofs


def _attempt(
    scene: Scene, times: Sequence[float], inputs: str, degree: int, digits: int, bound: float, limit: float,
    report: Any, ends: tuple[Scene, Scene] | None,
) -> Proven:  # fmt: skip
    """Return a proof with polynomials of a degree in a number of digits; it ends where the radius exceeds a bound."""
    began, bits = time.process_time(), int(digits * math.log2(10.0))
    units = _units(scene)
    header = _header(scene, times, inputs, bits, units, ends)
    proof, reason = Proof(header, compares=False), ""  # for the unit of time alone; the next one compares
    _, radius = propose(proof.formulas, Fraction(1), _constant(proof), ORDER, ROUGH_BITS)
    units = Units(units.length, _power(float(units.time) * radius / SAFETY), units.mass)
    header = _header(scene, times, inputs, bits, units, ends)
    proof = Proof(header)
    steps, share, unit, p, jacobian = [], 1.0 / SAFETY, Fraction(1), _constant(proof), None
    while proof.t < proof.times[-1] and not reason:
        if time.process_time() - began > limit:
            reason = "the prover has reached its limit of processor time"
            break
        try:
            p, radius = propose(proof.formulas, unit, p, degree, bits, jacobian)
        except (Refused, ArithmeticError, np.linalg.LinAlgError) as error:
            reason = f"no polynomial: {error}"
            break
        h = _dyadic(min(Fraction(radius * share) * unit, proof.times[-1] - proof.t))
        for attempt in range(ATTEMPTS):
            own, window = rescaled(p, h / unit, bits), Fraction(0)
            touch = first_touch(proof, h, own, WIDER**attempt) if scene.contacts else None
            if touch is not None:
                h, window = touch
                own = rescaled(p, h / unit, bits)
            try:
                proof.step(h, own, window)
                share = min(1.0 / SAFETY, share * LONGER)
                break
            except Refused as error:
                is_last = attempt == ATTEMPTS - 1 or h < SHORTEST * proof.times[-1]
                reason = f"a step is not proven: {error}" if is_last else ""
                if is_last:
                    break
                if touch is None or attempt % WIDENED == WIDENED - 1:
                    h, share = _dyadic(h * SHORTER), share * float(SHORTER)
        if reason:
            break
        steps.append([*h.as_integer_ratio(), own, *(window.as_integer_ratio() if window else ())])
        p = _constant(proof) if window else continued(p, h / unit, [*proof.middle, *proof.z], bits)
        unit, jacobian = h, None if window else np.tensordot(LATER, proof.jacobian, 1)
        report(float(proof.t * units.time), proof.radius)
        if proof.radius > bound:
            reason = f"the radius exceeds {bound:.1g}"
    log = header | {"steps": steps, "radius": proof.radius, "times": list(times)[: len(proof.enclosures)],
                    "reason": reason}  # fmt: skip
    return Proven(log, proof)


def _constant(proof: Proof) -> Polynomials:
    """Return constant polynomials from where a proof is."""
    return [[x] for x in (*proof.middle, *proof.z)]


def _dyadic(h: Fraction) -> Fraction:
    """Return h rounded up to a dyadic with 20 significant bits."""
    unit = Fraction(2) ** (math.frexp(float(h))[1] - 20)
    return math.ceil(h / unit) * unit


def _power(x: float) -> Fraction:
    return Fraction(2) ** round(math.log2(x))


def _units(scene: Scene) -> Units:
    scales = scales_of(scene)
    masses = [body.mass for body in scene.bodies]
    return Units(_power(scales.length), _power(scales.time), _power(math.exp(sum(map(math.log, masses)) / len(masses))))


def _header(
    scene: Scene, times: Sequence[float], inputs: str, bits: int, units: Units, ends: tuple[Scene, Scene] | None
) -> dict[str, Any]:
    whole = family(scene, *ends) if ends else scene
    return ({"ends": [one.model_dump(mode="json") for one in ends]} if ends else {}) | {
        "scene": scene.model_dump(mode="json"), "inputs": inputs, "bits": bits, "times": list(times),
        "system": derive(whole, READINGS[inputs], units),
    }  # fmt: skip


# --- Taylor polynomials of y' = f(y, z), 0 = g(y, z) by Newton's method, which the prover proposes

LAST = 6  # coefficients that state the radius of convergence: series may have gaps
SLOWEST = 2.0**-4  # 1 / radius of convergence at most, in units of time of the polynomials
ITERATIONS = 30  # of Newton's method
ROUGH = 2.0**-10  # of a correction, above which the Jacobian is computed again
BEST = 2.0**-40  # of a correction, the least next one that is expected: the Jacobian is in floats


def propose(
    formulas: Formulas, h: Fraction, p: Polynomials, degree: int, bits: int, jacobian: np.ndarray | None = None
) -> tuple[Polynomials, float]:  # fmt: skip
    """Return polynomials of y and z in units of time h, from p near them, and their radius of convergence in h.

    The start of y is that of p. Each iteration doubles the terms, at most. The radius is the least by the last
    coefficients of the polynomials and of the Jacobian, whose series near p's is computed unless given. Refused where
    Newton's method does not converge.
    """
    n, last = formulas.n, ROUGH
    jacobian = np.zeros((0, len(p), len(p))) if jacobian is None else jacobian
    for _ in range(ITERATIONS):
        count = min(2 * len(p[0]), degree + 1)
        before = last if count == len(p[0]) else 1.0
        p = [[*row, *[arb(0)] * (count - len(row))] for row in p]
        if last > ROUGH or len(jacobian) < min(ORDER, count):
            jacobian = Step(formulas, h, p).slopes()[0]
        with precision(bits + 32, count):
            values = formulas.run([*formulas.f, *formulas.g], [arb_series(row, count) for row in p])
            unit, defects = exact(h), [terms(value, count) for value in values]
            for k, row in enumerate(p[:n]):
                defects[k] = [unit * c - row[j + 1] * (j + 1) for j, c in enumerate(defects[k][:-1])] + [arb(0)]
            source = np.array([list(map(float, row)) for row in defects]).T[:, :, None]
            change = variations(jacobian, np.zeros((n, 1)), source)[:, :, 0].T
            p = [[(c + d).mid() for c, d in zip(*pair, strict=True)] for pair in zip(p, change.tolist(), strict=True)]
        size = np.array([list(map(float, row)) for row in p])
        last = np.max(np.abs(change) / np.maximum(np.abs(size), 1.0))
        if count > degree and last * max(BEST, min(1.0, last / before)) < 2.0**-bits:
            return p, 1.0 / max(SLOWEST, _growth(jacobian), _growth(size.T))
    raise Refused("Newton's method finds no polynomial")


def _growth(series: np.ndarray) -> float:
    """Return by which factor the last coefficients grow; of a coefficient, relative to 1 and to the first one."""
    size, last = np.maximum(np.abs(series[0]), 1.0), np.arange(len(series) - LAST, len(series))
    largest = np.max(np.abs(series[last]) / size, axis=tuple(range(1, series.ndim)))
    return float((largest ** (1.0 / last)).max())


def rescaled(p: Polynomials, ratio: Fraction, bits: int) -> list[list[int]]:
    """Return the coefficients over 2^bits in another unit of time, `ratio` of the first."""
    with precision(bits + 32):
        factors: list[Any] = [exact(ratio**k * 2**bits) for k in range(len(p[0]))]
        pairs = [zip(row, factors, strict=True) for row in p]
        return [[int((factor * c).mid().floor().unique_fmpz()) for c, factor in own] for own in pairs]


def continued(p: Polynomials, ratio: Fraction, start: list[arb], bits: int) -> Polynomials:
    """Return the polynomials from another start, a time `ratio` later, in units of that time."""
    with precision(bits + 32):
        later = arb_poly([exact(ratio), exact(ratio)])
        moved = [[c.mid() for c in arb_poly(row)(later).coeffs()] for row in p]
        return [[x, *row[1:], *[arb(0)] * (len(p[0]) - max(1, len(row)))] for x, row in zip(start, moved, strict=True)]
