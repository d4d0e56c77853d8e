#!/usr/bin/python3
"""Draws what the program wrote, for the guides: cells, sites, circles, energies. No other packages.

usage: draw.py cells OUT.png WIDTH OWNERS.csv...           owners of points on a WIDTH x WIDTH grid
       draw.py sites OUT.svg SITES.csv...                  point sets in the unit square
       draw.py circles OUT.svg SITES.csv POINTS.csv OWNERS.csv   a cell, and whose circles meet its own
       draw.py energies OUT.svg NAME=SUMMARY.json,... ...  energies by iterations made
"""

import json
import math
import pathlib
import struct
import sys
import zlib

INK, BLUE, ORANGE, GREY = "#1f2933", "#2b6cb0", "#dd6b20", "#cbd2d9"
HUES = [(0x9e, 0xc5, 0xe8), (0xf6, 0xc1, 0x91), (0xa8, 0xd5, 0xa2), (0xd9, 0xb8, 0xe3), (0xf2, 0xe2, 0x9b),
        (0xf0, 0xa8, 0xa8), (0xa6, 0xdc, 0xd8), (0xc9, 0xc3, 0xb1)]  # fmt: skip


def numbers(path):
    """The rows of a file of numbers; what is no number is a header."""
    rows = []
    for line in pathlib.Path(path).read_text().splitlines():
        try:
            rows.append([float(word) for word in line.split(",")])
        except ValueError:
            continue
    return rows


def write_png(path, width, height, rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    raw = b"".join(b"\0" + bytes(row) for row in rows)
    pathlib.Path(path).write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))  # fmt: skip


def cell_colours(owners, width):
    """Neighbouring cells get different colours, the first free one each."""
    beside = {}
    for p, owner in enumerate(owners):
        for q in ([p + 1] if (p + 1) % width else []) + ([p + width] if p + width < len(owners) else []):
            if owners[q] != owner:
                beside.setdefault(owner, set()).add(owners[q])
                beside.setdefault(owners[q], set()).add(owner)
    colour = {}
    for owner in sorted(set(owners)):
        taken = {colour.get(other) for other in beside.get(owner, ())}
        free = [c for c in range(len(HUES)) if c not in taken]
        colour[owner] = free[owner % len(free)] if free else owner % len(HUES)
    return {owner: HUES[c] for owner, c in colour.items()}


def cells(out, width, *files):
    width = int(width)
    scale = max(1, 288 // width)
    gap = 12
    side = width * scale
    total = side * len(files) + gap * (len(files) - 1)
    rows = [bytearray(b"\xff" * (3 * total)) for _ in range(side)]
    for panel, name in enumerate(files):
        owners = [int(row[0]) for row in numbers(name)]
        colour = cell_colours(owners, width)
        borders = sum(a != b for a, b in zip(owners, owners[1:])) < len(owners) / 2 or scale > 4
        for y in range(side):
            for x in range(side):
                at = (y // scale) * width + x // scale
                right = owners[at + 1] if (x + 1) % side and x % scale == scale - 1 else owners[at]
                below = owners[at + width] if y + 1 < side and y % scale == scale - 1 else owners[at]
                edge = borders and (right != owners[at] or below != owners[at])
                start = 3 * (panel * (side + gap) + x)
                rows[y][start:start + 3] = bytes((70, 80, 95) if edge else colour[owners[at]])  # fmt: skip
    write_png(out, total, side, rows)


def svg(out, width, height, body):
    pathlib.Path(out).write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">\n'
        f'<rect width="{width}" height="{height}" fill="#fff"/>\n' + "\n".join(body) + "\n</svg>\n")  # fmt: skip


def sites(out, *files):
    side, gap = 320, 16
    body = []
    for panel, name in enumerate(files):
        left = panel * (side + gap)
        points = numbers(name)
        radius = 80 / math.sqrt(len(points)) * .85
        body.append(f'<rect x="{left + .5}" y=".5" width="{side - 1}" height="{side - 1}" fill="none" stroke="{GREY}"/>')
        body += [f'<circle cx="{left + x * side:.1f}" cy="{y * side:.1f}" r="{radius:.2f}" fill="{INK}"/>'
                 for x, y in points]  # fmt: skip
    svg(out, side * len(files) + gap * (len(files) - 1), side, body)


def circles(out, site_file, point_file, owner_file):
    side = 420
    centres = numbers(site_file)
    radius = [0.0] * len(centres)
    points = numbers(point_file)
    owners = [int(row[0]) for row in numbers(owner_file)]
    for p, s in zip(points, owners):
        radius[s] = max(radius[s], math.dist(p, centres[s]))
    chosen = min(range(len(centres)), key=lambda s: math.dist(centres[s], (.5, .5)))
    meet = [s for s, c in enumerate(centres)
            if math.dist(c, centres[chosen]) <= radius[s] + radius[chosen]]  # fmt: skip
    body = []
    for p, s in zip(points, owners):
        shade = "#f6c191" if s == chosen else "#c9def2" if s in meet else "#edf0f3"
        body.append(f'<circle cx="{p[0] * side:.1f}" cy="{p[1] * side:.1f}" r="2.1" fill="{shade}"/>')
    for s, (x, y) in enumerate(centres):
        stroke = ORANGE if s == chosen else BLUE if s in meet else None
        if stroke:
            body.append(f'<circle cx="{x * side:.1f}" cy="{y * side:.1f}" r="{radius[s] * side:.1f}" '
                        f'fill="none" stroke="{stroke}" stroke-width="{2.5 if s == chosen else 1}"/>')  # fmt: skip
        body.append(f'<circle cx="{x * side:.1f}" cy="{y * side:.1f}" r="3" fill="{stroke or "#9aa5b1"}"/>')
    svg(out, side, side, body)


def energies(out, *curves):
    width, height, left, bottom = 660, 330, 60, 290
    runs = {}
    for curve in curves:
        name, files = curve.split("=")
        read = [json.loads(pathlib.Path(file).read_text()) for file in files.split(",")]
        runs[name] = [(run["iterations"], run["normalized_energy"]) for run in read]
    last = max(x for run in runs.values() for x, _ in run)
    low = min(y for run in runs.values() for _, y in run) * .995
    high = min(.25, max(y for run in runs.values() for _, y in run))

    def place(x, y):
        return left + x / last * (width - left - 20), bottom - (min(y, high) - low) / (high - low) * (bottom - 20)

    body = [f'<path d="M{left} 14V{bottom}H{width - 14}" fill="none" stroke="{INK}"/>']
    for tick in range(0, last + 1, 10):
        x, y = place(tick, low)
        body.append(f'<text x="{x}" y="{y + 18}" text-anchor="middle" fill="{INK}">{tick}</text>')
    for tick in [t / 100 for t in range(1, 100) if low <= t / 100 <= high]:
        y = place(0, tick)[1]
        body.append(f'<path d="M{left} {y:.1f}H{width - 14}" stroke="{GREY}"/>')
        body.append(f'<text x="{left - 6}" y="{y + 4:.1f}" text-anchor="end" fill="{INK}">{tick:.2f}</text>'.replace(">0.", ">."))  # fmt: skip
    for (name, run), colour in zip(runs.items(), [ORANGE, BLUE, INK]):
        line = " ".join("%.1f,%.1f" % place(x, y) for x, y in run)
        body.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2.5"/>')
        body.append(f'<text x="{width - 20}" y="{40 + 20 * list(runs).index(name)}" text-anchor="end" fill="{colour}">{name}</text>')
    body.append(f'<text x="{width - 14}" y="{height - 6}" text-anchor="end" fill="{INK}">iterations made</text>')
    svg(out, width, height, body)


if __name__ == "__main__":
    globals()[sys.argv[1]](*sys.argv[2:])
