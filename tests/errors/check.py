#!/usr/bin/python3
"""Every exception that the library and the program throw has an example that a test provokes.

Finds in include/ and src/ what makes messages: `throw`, and the functions that throw what they are
given. README.md beside this file has an example of each.

usage: check.py                     whether README.md has an example of every message, and no other
       check.py --record RECORD     the same of what tests threw, a file that recorder.cpp wrote, and
                                    whether README.md's examples are among it
       check.py --write RECORD      writes README.md anew, with examples from there
"""
import pathlib
import re
import sys

from advice import ADVICE, CANNOT_BE_PROVOKED

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PAGE = HERE / "README.md"
# Of Python's tests, and of the build.
SKIPPED = ("src/python/", "src/cli/pages/", "src/mpi/pages.cpp")
LONGEST = 300  # letters of an example

TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)\'', re.S)
START = re.compile(
    r"\bthrow\s+(?:\w+::)*(\w+)\s*[({]"
    r"|(?<![\w:~])((?:[\w()]+(?:\.|->))?fail(?:_to_write)?)\s*\((?=[^)])")


def without_comments(text):
    """The text with comments blanked, as long as before."""
    def blank(match):
        found = match.group(0)
        return re.sub(r"[^\n]", " ", found) if found.startswith("/") else found
    return TOKEN.sub(blank, text)


def end_of_call(text, at):
    """Behind the bracket that closes the one at `at`."""
    depth = 0
    while True:
        token = TOKEN.match(text, at)
        if token:
            at = token.end()
            continue
        depth += (text[at] in "({[") - (text[at] in ")}]")
        at += 1
        if depth == 0:
            return at


def constant_parts(expression):
    """The constant texts of a message, those of neighbours joined."""
    found = []
    last = None
    for token in TOKEN.finditer(expression):
        if not token.group(0).startswith('"'):
            continue
        text = re.sub(r"\\(.)", r"\1", token.group(0)[1:-1])
        if last is not None and not expression[last:token.start()].strip():
            found[-1] += text
        else:
            found.append(text)
        last = token.end()
    return found


class Message:
    """One place in the sources that makes a message."""

    def __init__(self, file, line, parts):
        self.file, self.line, self.parts = file, line, parts
        self.longest = max(parts, key=len)
        self.name = " … ".join(part.strip() for part in parts if part.strip())

    def fit(self, text):
        """How many letters of `text` are constant here; 0: it is another message."""
        if self.longest not in text:
            return 0
        at, letters = 0, 0
        for part in self.parts:  # of alternatives one is there
            found = text.find(part, at)
            if found >= 0:
                at, letters = found + len(part), letters + len(part)
        return letters


def messages():
    """All messages. What only hands on a text that is made elsewhere is none."""
    found = []
    for path in sorted([*(ROOT / "include").rglob("*"), *(ROOT / "src").rglob("*")]):
        file = str(path.relative_to(ROOT))
        if path.suffix not in (".h", ".cpp") or file.startswith(SKIPPED):
            continue
        text = without_comments(path.read_text())
        for match in START.finditer(text):
            if text[:match.start()].rstrip().endswith("void"):
                continue  # a declaration
            expression = text[match.start():end_of_call(text, match.end() - 1)]
            if re.search(r"(?<!\.)\b(message|reason)\b", expression):
                continue
            parts = constant_parts(expression)
            if any(re.search("[a-zA-Z]{2}", part) for part in parts):
                found.append(Message(file, text.count("\n", 0, match.start()) + 1, parts))
    return found


def plain(text):
    """An example without what differs from run to run."""
    text = re.sub(r"/[\w./-]*/(?:ccvt-test-\w+)/?", "", text)
    text = "".join(letter if " " <= letter else "?" for letter in text)
    return text if len(text) <= LONGEST else text[:LONGEST - 1] + "…"


def examples_from(texts, wanted):
    """For each message the shortest of the texts that it fits better than any other does, or, where
    there is none, that it fits."""
    examples, others = {}, {}
    for text in sorted(set(texts), key=lambda text: (len(text), text)):
        fits = [(message.fit(text), index) for index, message in enumerate(wanted)]
        best = max(fits)[0]
        for fit, index in fits:
            if best > 0 and fit == best:
                examples.setdefault(index, text)
            elif fit > 0:
                others.setdefault(index, text)
    return {**others, **examples}


def cell(text):
    return "`" + text.replace("|", "\\|").replace("`", "'") + "`"


def page_of(wanted, examples):
    lines = ["# Errors", "",
             "What the library and the program say when something is wrong, each with an example "
             "that a test provokes, by the source file that says it. Made by "
             "[check.py](check.py): do not edit.", ""]
    files = sorted({message.file for message in wanted})
    for file in files:
        lines += ["## " + file, "", ADVICE[file], "", "| message | example |", "|---|---|"]
        rows = []
        for index, message in enumerate(wanted):
            if message.file != file:
                continue
            reason = CANNOT_BE_PROVOKED.get((file, message.longest))
            shown = cell(examples[index]) if index in examples else "no test: " + reason
            rows.append(f"| {cell(message.name)} | {shown} |")
        lines += list(dict.fromkeys(rows)) + [""]
    return "\n".join(lines)


def examples_of_page():
    rows = re.findall(r"^\| `.*` \| `(.*)` \|$", PAGE.read_text(), re.M)
    return [row.replace("\\|", "|") for row in rows]


def main():
    wanted = messages()
    action = sys.argv[1] if len(sys.argv) > 1 else ""
    recorded = action in ("--record", "--write")
    texts = [plain(line) for line in pathlib.Path(sys.argv[2]).read_text(
        errors="replace").splitlines()] if recorded else examples_of_page()
    examples = examples_from(texts, wanted)
    problems = []
    reasons = {(message.file, message.longest) for message in wanted}
    for key in CANNOT_BE_PROVOKED:
        if key not in reasons:
            problems.append(f"advice.py: there is no message {key}")
    for index, message in enumerate(wanted):
        excused = (message.file, message.longest) in CANNOT_BE_PROVOKED
        if index not in examples and not excused:
            problems.append(f"{message.file}:{message.line}: no test provokes: {message.name}")
        if message.file not in ADVICE:
            problems.append(f"advice.py: says nothing of {message.file}")
    if action == "--record":
        thrown = {cell(text) for text in texts}
        problems += [f"README.md: no test says: {text}" for text in examples_of_page()
                     if cell(text) not in thrown]
    for problem in dict.fromkeys(problems):
        print(problem)
    if problems:
        return 1
    if action == "--write":
        PAGE.write_text(page_of(wanted, examples))
    elif action == "" and page_of(wanted, examples) != PAGE.read_text():
        print("README.md is not what the sources say; record the tests and write it anew")
        return 1
    print(f"{len(wanted)} messages, {len(wanted) - len(examples)} of them without an example")
    return 0


if __name__ == "__main__":
    sys.exit(main())
