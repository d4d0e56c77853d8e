#!/usr/bin/env python3
"""Writes the mesh of figures/surface.png, a trefoil knot of a bumpy tube, as an OBJ file."""
import math
import sys

AROUND, ACROSS = 900, 64


def curve(t):
    return (math.sin(t) + 2 * math.sin(2 * t), math.cos(t) - 2 * math.cos(2 * t), -math.sin(3 * t))


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


with open(sys.argv[1], "w", encoding="ascii") as out:
    for i in range(AROUND):
        t = 2 * math.pi * i / AROUND
        here, ahead, behind = curve(t), curve(t + 1e-4), curve(t - 1e-4)
        along = unit([a - b for a, b in zip(ahead, behind)])
        side = unit(cross(along, (0, 0, 1)))
        up = cross(side, along)
        for j in range(ACROSS):
            a = 2 * math.pi * j / ACROSS
            r = 0.62 + 0.1 * math.sin(12 * t) * math.sin(2 * a)
            place = [c + r * (math.cos(a) * s + math.sin(a) * u) for c, s, u in zip(here, side, up)]
            print("v %.6f %.6f %.6f" % tuple(place), file=out)
    for i in range(AROUND):
        for j in range(ACROSS):
            corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
            print("f", *[1 + k % AROUND * ACROSS + l % ACROSS for k, l in corners], file=out)
