"""Writes table.txt: sines and cosines by mpmath (https://mpmath.org), to 2000 bits.

A line holds the bits of x, those of the double nearest to sin x and how far sin x lies above it in units of its
last place, and the same of cos x.   python3 make_table.py > table.txt
"""

import math
import random
import struct

from mpmath import mp, mpf, cos, floor, frexp, ldexp, pi, sin

mp.prec = 2000


def bits(x):
    return struct.unpack("<Q", struct.pack("<d", x))[0]


def nearest(value):
    """The double nearest to a value, and how far the value is above it, in units in its last place."""
    exponent = max(frexp(value)[1] - 53, -1074)
    double = float(ldexp(floor(ldexp(value, -exponent) + mpf("0.5")), exponent))
    return double, float((value - double) / math.ulp(double))


def close_to_a_multiple(exponent):
    """A double of [2^exponent, 2^(exponent + 1)) very close to a multiple of π/2, by the convergents p/q of
    π/2 in units of the last place (J.-M. Muller, "Elementary Functions", section 11.3)."""
    ratio = ldexp(pi / 2, 52 - exponent)
    (p0, p1), best = (0, 1), None
    while p1 < 2**53:
        best = p1 or best
        whole = int(floor(ratio))
        p0, p1 = p1, whole * p1 + p0
        ratio = 1 / (ratio - whole)
    return float(ldexp(mpf(best * ((2**53 - 1) // best)), exponent - 52))


def arguments():
    generator = random.Random(1)
    for exponent in [*range(0, 24), *range(24, 1024, 4)]:
        yield close_to_a_multiple(exponent)
    yield ldexp(mpf(6381956970095103), 797)
    for exponent in range(-1074, 1024, 7):
        x = ldexp(mpf(generator.randrange(2**52, 2**53)), exponent - 52)
        yield nearest(x)[0]
    for value in [0.0, 5e-324, 2.0**-1022, 2.0**-27, 2.0**-26, 0.5, 1.0, 2.0**20, 2.0**30, 2.0**1023]:
        yield value
        yield nearest(mpf(value) * (1 + ldexp(mpf(1), -52)))[0]
    for k in range(1, 12):
        yield nearest(k * pi / 4)[0]
    for _ in range(100):
        yield generator.uniform(-4.0, 4.0)
    yield float.fromhex("0x1.fffffffffffffp+1023")


for x in map(float, arguments()):
    line = f"{bits(x):016x}"
    for value in (sin(mpf(x)), cos(mpf(x))):
        double, rest = nearest(value)
        line += f" {bits(double):016x} {rest:+.6f}"
    print(line)
