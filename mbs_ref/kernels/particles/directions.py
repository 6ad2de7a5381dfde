"""Where poles, Moon and Sun point: closed series in time. All in ICRF axes; d is days from J2000 TDB."""

import numpy as np

from mbs_ref.kernels.jit import jit

ARCSEC = np.pi / 648_000.0  # rad
DEGREE = np.pi / 180.0  # rad
CENTURY = 36_525.0  # days
OBLIQUITY = 84_381.406 * ARCSEC  # rad, of the ecliptic of J2000 (IAU 2006)


@jit
def earth_pole(d, axis):
    """The celestial pole: precession and the 18.6-year nutation (IERS Conventions 2010, eq 5.16, 5.43)."""
    t = d / CENTURY
    node = 125.04455501 * DEGREE - 6_962_890.5431 * t * ARCSEC
    x = -0.016617 + t * (2004.191898 - 0.4297829 * t - 0.19861834 * t * t)
    y = -0.006951 + t * (-0.025896 - 22.4072747 * t + 0.00190059 * t * t)
    x += -6.844318 * np.sin(node)
    y += 9.205236 * np.cos(node)
    axis[0], axis[1] = x * ARCSEC, y * ARCSEC
    axis[2] = np.sqrt(1.0 - axis[0] * axis[0] - axis[1] * axis[1])


@jit
def moon_axes(d, axes):
    """Rows: the Moon's x (towards the Earth), y and z axes (Archinal et al. 2011, table 2)."""
    t = d / CENTURY
    e1 = (125.045 - 0.0529921 * d) * DEGREE
    e2 = (250.089 - 0.1059842 * d) * DEGREE
    e3 = (260.008 + 13.0120009 * d) * DEGREE
    e4 = (176.625 + 13.3407154 * d) * DEGREE
    e5 = (357.529 + 0.9856003 * d) * DEGREE
    e6 = (311.589 + 26.4057084 * d) * DEGREE
    e7 = (134.963 + 13.0649930 * d) * DEGREE
    e8 = (276.617 + 0.3287146 * d) * DEGREE
    e9 = (34.226 + 1.7484877 * d) * DEGREE
    e10 = (15.134 - 0.1589763 * d) * DEGREE
    e11 = (119.743 + 0.0036096 * d) * DEGREE
    e12 = (239.961 + 0.1643573 * d) * DEGREE
    e13 = (25.053 + 12.9590088 * d) * DEGREE
    ascension = 269.9949 + 0.0031 * t - 3.8787 * np.sin(e1) - 0.1204 * np.sin(e2) + 0.0700 * np.sin(e3)
    ascension += -0.0172 * np.sin(e4) + 0.0072 * np.sin(e6) - 0.0052 * np.sin(e10) + 0.0043 * np.sin(e13)
    declination = 66.5392 + 0.0130 * t + 1.5419 * np.cos(e1) + 0.0239 * np.cos(e2) - 0.0278 * np.cos(e3)
    declination += 0.0068 * np.cos(e4) - 0.0029 * np.cos(e6) + 0.0009 * np.cos(e7) + 0.0008 * np.cos(e10)
    declination -= 0.0009 * np.cos(e13)
    turn = 38.3213 + 13.17635815 * d - 1.4e-12 * d * d + 3.5610 * np.sin(e1) + 0.1208 * np.sin(e2)
    turn += -0.0642 * np.sin(e3) + 0.0158 * np.sin(e4) + 0.0252 * np.sin(e5) - 0.0066 * np.sin(e6)
    turn += -0.0047 * np.sin(e7) - 0.0046 * np.sin(e8) + 0.0028 * np.sin(e9) + 0.0052 * np.sin(e10)
    turn += 0.0040 * np.sin(e11) + 0.0019 * np.sin(e12) - 0.0044 * np.sin(e13)
    a, b, w = ascension * DEGREE, declination * DEGREE, turn * DEGREE
    pole = (np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b))
    node = (-np.sin(a), np.cos(a), 0.0)  # the ascending node of the equator, at right ascension a + 90 degrees
    third = (-np.sin(b) * np.cos(a), -np.sin(b) * np.sin(a), np.cos(b))
    for k in range(3):
        axes[0, k] = np.cos(w) * node[k] + np.sin(w) * third[k]
        axes[1, k] = -np.sin(w) * node[k] + np.cos(w) * third[k]
        axes[2, k] = pole[k]


@jit
def _from_ecliptic(longitude, latitude, distance, place):
    c, s = np.cos(OBLIQUITY), np.sin(OBLIQUITY)
    x = distance * np.cos(latitude) * np.cos(longitude)
    y = distance * np.cos(latitude) * np.sin(longitude)
    z = distance * np.sin(latitude)
    place[0], place[1], place[2] = x, c * y - s * z, s * y + c * z


@jit
def sun_place(d, place):
    """The Sun from the Earth, m (Montenbruck and Gill 2000, eq 3.43-3.44)."""
    m = (357.5256 + 35_999.049 * d / CENTURY) * DEGREE
    longitude = 282.9400 * DEGREE + m + (6892.0 * np.sin(m) + 72.0 * np.sin(2.0 * m)) * ARCSEC
    distance = (149.619 - 2.499 * np.cos(m) - 0.021 * np.cos(2.0 * m)) * 1e9
    _from_ecliptic(longitude, 0.0, distance, place)


@jit
def moon_place(d, place):
    """The Moon from the Earth, m (Montenbruck and Gill 2000, eq 3.47-3.51)."""
    t = d / CENTURY
    mean = (218.31617 + 481_267.88088 * t - 1.3972 * t) * DEGREE
    l = (134.96292 + 477_198.86753 * t) * DEGREE  # noqa: E741
    ls = (357.52543 + 35_999.04944 * t) * DEGREE
    f = (93.27283 + 483_202.01873 * t) * DEGREE
    e = (297.85027 + 445_267.11135 * t) * DEGREE
    sin = np.sin
    lon = 22_640.0 * sin(l) + 769.0 * sin(2 * l) - 4586.0 * sin(l - 2 * e) + 2370.0 * sin(2 * e) - 668.0 * sin(ls)
    lon += -412.0 * sin(2 * f) - 212.0 * sin(2 * l - 2 * e) - 206.0 * sin(l + ls - 2 * e) + 192.0 * sin(l + 2 * e)
    lon += -165.0 * sin(ls - 2 * e) + 148.0 * sin(l - ls) - 125.0 * sin(e) - 110.0 * sin(l + ls)
    lon -= 55.0 * sin(2 * f - 2 * e)
    longitude = mean + lon * ARCSEC
    lat = 18_520.0 * sin(f + longitude - mean + (412.0 * sin(2 * f) + 541.0 * sin(ls)) * ARCSEC)
    lat += -526.0 * sin(f - 2 * e) + 44.0 * sin(l + f - 2 * e) - 31.0 * sin(-l + f - 2 * e) - 25.0 * sin(-2 * l + f)
    lat += -23.0 * sin(ls + f - 2 * e) + 21.0 * sin(-l + f) + 11.0 * sin(-ls + f - 2 * e)
    cos = np.cos
    distance = 385_000.0 - 20_905.0 * cos(l) - 3699.0 * cos(2 * e - l) - 2956.0 * cos(2 * e) - 570.0 * cos(2 * l)
    distance += 246.0 * cos(2 * l - 2 * e) - 205.0 * cos(ls - 2 * e) - 171.0 * cos(l + 2 * e)
    distance -= 152.0 * cos(l + ls - 2 * e)
    _from_ecliptic(longitude, lat * ARCSEC, distance * 1e3, place)
