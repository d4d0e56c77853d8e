#!/usr/bin/python3
"""Holds the table of architecture.md against all includes, and draws them.

A file of `src` may include files of its own folder, files without a folder in its own row, and
what rows below have. A header of include/ccvt that the table names counts as its row, others as
below all.

usage: layers.py [OUT.dot]
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)
GENERATED = {"ccvt/export.h", "ccvt/version.h"}


def read_table():
    """The row of each module and public header, the rows' names, and which modules are folders."""
    rows, names = {}, []
    for line in (ROOT / "src/docs/architecture.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("| ") or len(cells) != 4 or cells[0] == "layer":
            continue
        for module in re.findall(r"`([^`]+)`", cells[1]):
            rows[module] = len(names)
        for header in re.findall(r"`([^`]+)`", cells[2]):
            rows[f"ccvt/{header}"] = len(names)
        names.append(cells[0])
    return rows, names


def module_of(path):
    """cli of cli/run.cpp, numbers of numbers.h."""
    return path.parts[0] if len(path.parts) > 1 else path.stem


def edges():
    """All includes: the file, what it is of, and what it includes is of."""
    for folder in ("src", "include"):
        base = ROOT / folder
        for file in sorted(base.rglob("*")):
            if file.suffix not in (".h", ".cpp") or "examples" in file.parts:
                continue
            inner = file.relative_to(base)
            source = str(inner) if folder == "include" else module_of(inner)
            for name in INCLUDE.findall(file.read_text()):
                if name in GENERATED:
                    continue
                if name.startswith("ccvt/"):
                    yield file, source, name
                elif (file.parent / name).exists() and "/" not in name and len(inner.parts) > 1:
                    yield file, source, source
                else:
                    yield file, source, module_of(pathlib.Path(name))


def problems(rows, all_edges):
    folders = {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
    for file, source, target in all_edges:
        name = file.relative_to(ROOT)
        public = [module.startswith("ccvt/") for module in (source, target)]
        if source not in rows and not public[0]:
            yield f"{name}: {source} has no row in architecture.md"
        elif target not in rows and not public[1]:
            yield f"{name}: includes {target}, which has no row in architecture.md"
        elif source != target and target in rows:
            own = rows.get(source, len(rows))
            beside = own == rows[target] and not {source, target} & folders
            beside = beside or all(public) or pathlib.Path(target).stem == source
            if own > rows[target] or (own == rows[target] and not beside):
                yield f"{name}: includes {target}, which is not below {source}"
    for module in rows:
        known = [ROOT / "src" / module, ROOT / f"src/{module}.h", ROOT / f"src/{module}.cpp", ROOT / "include" / module]
        if not any(path.exists() for path in known):
            yield f"architecture.md: there is no {module}"


def draw(out, rows, names, all_edges):
    """Folders as they include each other, without what follows from other arrows."""
    folders = {module for module in rows if (ROOT / "src" / module).is_dir()}

    def node(module):
        return module if module in folders else f"row {rows[module]}" if module in rows else None

    below = {}
    for _, source, target in all_edges:
        a, b = node(source), node(target)
        if a and b and a != b and not target.startswith("ccvt/"):
            below.setdefault(a, set()).add(b)

    def reach(a):
        found, waiting = set(), list(below.get(a, ()))
        while waiting:
            b = waiting.pop()
            if b not in found:
                found.add(b)
                waiting += below.get(b, ())
        return found

    lines = ["digraph layers {", 'rankdir=TB; nodesep=.25; ranksep=.35; bgcolor="white";',
             'node [shape=box, style="rounded,filled", fillcolor="#e7eff8", color="#7a9cc0", fontname="sans-serif", fontsize=11];',
             'edge [color="#8fa3b8", arrowsize=.6];']  # fmt: skip
    for row, name in enumerate(names):
        here = sorted({node(m) for m in rows if rows[m] == row and not m.startswith("ccvt/")})
        plain = [m for m in rows if rows[m] == row and m not in folders and not m.startswith("ccvt/")]
        lines.append(f'"label {row}" [label="{name}", shape=plaintext, style="", fontsize=12];')
        lines += [f'"{n}" [fillcolor="#f6f0e4", color="#c9b68c", label="{label_of(plain)}"];' for n in here if n.startswith("row")]
        lines.append("{rank=same; " + "; ".join(f'"{n}"' for n in [f"label {row}", *here]) + "}")
        if row:
            lines.append(f'"label {row - 1}" -> "label {row}" [style=invis];')
    for a in sorted(below):
        indirect = set().union(*(reach(b) for b in below[a] - {a}))
        lines += [f'"{a}" -> "{b}";' for b in sorted(below[a] - indirect)]
    pathlib.Path(out).write_text("\n".join([*lines, "}"]) + "\n")


def label_of(plain):
    return ", ".join(plain) if len(plain) < 5 else ", ".join(plain[:3]) + f", … ({len(plain)} files)"


def main():
    rows, names = read_table()
    all_edges = list(edges())
    found = sorted(set(problems(rows, all_edges)))
    print("\n".join([*found, f"layers: {len(all_edges)} includes in {len(names)} rows, {len(found)} against the rule"]))
    if len(sys.argv) > 1:
        draw(sys.argv[1], rows, names, all_edges)
    return 1 if found or len(names) < 5 or len(all_edges) < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
