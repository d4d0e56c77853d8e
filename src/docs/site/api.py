#!/usr/bin/python3
"""Checks, in Doxygen's XML, that each class, enumeration and function of the interface is told of.

Of overloads one is enough, and of members of a class data, constructors and what is a word for its
name (`size()`, `begin()`) need no telling.

usage: api.py XML
"""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def told(element):
    return any("".join(part.itertext()).strip()
               for kind in ("briefdescription", "detaileddescription")
               for part in element.findall(kind))  # fmt: skip


def untold(folder):
    found = []
    checked = 0
    for entry in ElementTree.parse(folder / "index.xml").getroot().findall("compound"):
        if entry.get("kind") not in ("class", "struct", "namespace"):
            continue
        compound = ElementTree.parse(folder / f"{entry.get('refid')}.xml").getroot().find("compounddef")
        name = compound.findtext("compoundname")
        if entry.get("kind") != "namespace":
            checked += 1
            if not told(compound):
                found.append(name)
            continue
        names = {}
        for member in compound.iter("memberdef"):
            if member.get("kind") in ("function", "enum", "typedef"):
                names.setdefault(member.findtext("name"), []).append(told(member))
        names.pop("Problem", None)  # a deduction guide
        checked += len(names)
        found += [f"{name}::{member}" for member, tellings in names.items() if not any(tellings)]
    return found, checked


def main():
    found, checked = untold(pathlib.Path(sys.argv[1]))
    for name in found:
        print(f"no word is said of {name}")
    print(f"interface: {checked} names, {len(found)} without a word")
    return 1 if found or checked < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
