"""Contacts of free bodies as drivers of engines read them; it runs under the Python of each engine, from 3.9 on."""

import json
import sys
from importlib.metadata import version


def read(package):
    """Return the problem of standard input: step (s), counts of steps, gravity, bodies and contacts."""
    if sys.argv[1:]:  # --version
        sys.exit(print(version(package)))
    return json.load(sys.stdin)


def turned(q, v):
    """Return v (3,) turned by Euler parameters q."""
    w, x, y, z = q
    t = [2.0 * (y * v[2] - z * v[1]), 2.0 * (z * v[0] - x * v[2]), 2.0 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]]  # fmt: skip


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))  # noqa: B905 - Python 3.9 has no strict


def touch(contact, poses):
    """Return gap (m), normal from b to a and place (m) of a contact; `poses` are place and Euler parameters of each."""
    (ra, qa), (rb, qb) = poses
    centre = [p + q for p, q in zip(ra, turned(qa, contact["center"]))]  # noqa: B905
    origin = [p + q for p, q in zip(rb, turned(qb, contact["origin"]))]  # noqa: B905
    apart = [p - q for p, q in zip(centre, origin)]  # noqa: B905
    if "axes" in contact:
        along, across, normal = (turned(qb, axis) for axis in contact["axes"])
        gap = dot(apart, normal) - contact["radius"]
        sides = contact["sides"]
        beyond = 2.0 * abs(dot(apart, along)) > sides[0] or 2.0 * abs(dot(apart, across)) > sides[1]
        gap = 1.0 if beyond or -gap > contact["thickness"] else gap
    else:
        distance = dot(apart, apart) ** 0.5
        normal, gap = [p / distance for p in apart], distance - contact["radius"] - contact["other"]
    return gap, normal, [p - contact["radius"] * n for p, n in zip(centre, normal)]  # noqa: B905
