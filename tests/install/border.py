#!/usr/bin/env python3
"""Holds the rule of the border (see include/ccvt/README.md) against the public headers.

usage: border.py CLANG FLAG...

No Eigen type may be part of a declaration that the library compiles: not as a parameter or result
of a function without a body, not as a member of a class that is not a template of the user's own.
The declarations are those that clang's syntax tree of ccvt/ccvt.h shows. Exit status 1 when one
breaks the rule.
"""

import re
import subprocess
import sys

# Declarations that break the rule, each in a way of its own: what the check has to find first.
BROKEN = """namespace ccvt {
CCVT_EXPORT Eigen::VectorXd bad_result();
CCVT_EXPORT void bad_parameter(const Points<double>& points);
template <class Scalar> CCVT_EXPORT Points<Scalar> bad_template(int count);
struct CCVT_EXPORT Bad {
  Eigen::Vector3d member;
  Points<float> bad_method() const;
};
using Row = Eigen::VectorXd;
CCVT_EXPORT Row bad_alias();
}
"""
LINE = re.compile(r"^(?P<indent>[ |`-]*)(?P<kind>[A-Z]\w+Decl) 0x\w+ (?P<rest>.*)$")
FUNCTIONS = {"FunctionDecl", "CXXMethodDecl", "CXXConstructorDecl", "CXXConversionDecl"}
# Compiled by the user, always: their members are templates or have bodies, which is checked too.
USERS_OWN = {"Result"}


def rule_breakers(source):
    """The number of declarations, and a line for each that breaks the rule."""
    command = [sys.argv[1], "-std=c++20", "-fsyntax-only", "-fno-color-diagnostics",
               "-Xclang", "-ast-dump", "-Xclang", "-ast-dump-filter=ccvt",
               *sys.argv[2:], "-x", "c++", "-"]
    tree = subprocess.run(command, input=source, capture_output=True,
                          text=True, check=True).stdout.splitlines()
    aliases = {re.search(r" (\w+) '", line)[1] for line in tree
               if "AliasDecl" in line and re.search(r" \w+ '.*Eigen::", line)}
    eigen = re.compile(r"\bEigen::" + "".join(rf"|\b{name}\b" for name in sorted(aliases)))
    checked = 0
    broken = []
    open_class = []  # (depth, name) of the classes that a line is in
    for number, line in enumerate(tree):
        match = LINE.match(line)
        if not match:
            continue
        depth, kind, rest = len(match["indent"]), match["kind"], match["rest"]
        while open_class and open_class[-1][0] >= depth:
            open_class.pop()
        if kind in ("CXXRecordDecl", "ClassTemplateSpecializationDecl"):
            name = re.search(r"(?:struct|class) (\w+)", rest)
            # Specializations repeat what the template says, without bodies.
            open_class.append((depth, name[1] if name else "", kind != "CXXRecordDecl"))
            continue
        if any(repeated for _, _, repeated in open_class):
            continue
        quoted = re.search(r" (\w+|operator\S*|operator [^']*) '([^']*)'", rest)
        if kind == "FieldDecl" and quoted:
            checked += 1
            owner = open_class[-1][1] if open_class else ""
            if eigen.search(quoted[2]) and owner not in USERS_OWN:
                broken.append(f"member {owner}::{quoted[1]} is a {quoted[2]}")
        elif kind in FUNCTIONS and quoted and not re.search(r"\bimplicit\b", rest.split("'")[0]):
            checked += 1
            if eigen.search(quoted[2]) and not has_body(tree, number, depth):
                broken.append(f"{quoted[1]} is compiled by the library, but is {quoted[2]}")
    return checked, broken


def main():
    include = "#include <ccvt/ccvt.h>\n"
    checked, broken = rule_breakers(include)
    found = len(rule_breakers(include + BROKEN)[1]) - len(broken)
    if checked < 200 or found != 6:
        print(f"the check does not work: {checked} declarations, {found} of 6 faults found")
        return 1
    for text in broken:
        print(text)
    print(f"{checked} declarations, {len(broken)} of which break the rule of the border")
    return 1 if broken else 0


def has_body(tree, number, depth):
    """Whether a statement stands below the declaration in line `number`."""
    for line in tree[number + 1:]:
        inner = re.match(r"^([ |`-]*)(\w+)", line)
        if not inner or len(inner[1]) <= depth:
            return False
        if inner[2] in ("CompoundStmt", "CXXTryStmt"):
            return True
    return False


if __name__ == "__main__":
    sys.exit(main())
