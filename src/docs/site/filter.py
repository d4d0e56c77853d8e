#!/usr/bin/python3
"""Prints a file as Doxygen is to see it; for FILTER_PATTERNS. Lines stay where they are.

Headers: a comment in front of the namespace is the file's; "#points" is no link. Markdown: headings
get the anchors that Git hosts give them, and links to files of the repository lead to pages of the
site: to the guides, to the reference of headers, or to copies below files/, which build.sh makes.
A line `<!-- site: TEXT -->` is TEXT on the site, and nothing elsewhere.

usage: filter.py FILE
       filter.py --files           prints the files of which the site needs copies
       filter.py --pictures DIR    copies the repository's pictures there, under names of their own
"""

import functools
import pathlib
import posixpath
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
PAGES = {str(path.relative_to(ROOT)): path.stem for path in sorted((ROOT / "src/docs").glob("*.md"))} | {
    "CHANGELOG.md": "changelog",
    "benchmarks/README.md": "benchmarks",
    "benchmarks/results/report.md": "results",
    "benchmarks/results/growth/report.md": "results_growth",
    "benchmarks/results/search_clouds/report.md": "results_search_clouds",
    "benchmarks/results/search_clouds_1m/report.md": "results_search_clouds_1m",
    "benchmarks/results/search_mnist/report.md": "results_search_mnist",
    "benchmarks/results/thin/report.md": "results_thin",
    "include/ccvt/README.md": "structure",
    "src/python/README.md": "python_reference",
    "tests/errors/README.md": "errors",
    "tests/examples/README.md": "examples",
}  # fmt: skip
TITLES = {  # of reports, which have none
    "results": "The paper's table and figures",
    "results_growth": "Many points a site",
    "results_search_clouds": "Inverted lists: clouds",
    "results_search_clouds_1m": "Inverted lists: a million vectors in clouds",
    "results_search_mnist": "Inverted lists: MNIST",
}
PAGES["README.md"] = "index"  # says the same in other words
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")


def slug(heading):
    """The anchor that Git hosts make of a heading."""
    text = re.sub(r"[`*]|\]\([^)]*\)|[\[\]]", "", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def label(page, anchor):
    return f"{PAGES[page]}-{anchor}" if anchor else PAGES[page]


def target_of(page, link):
    """What a relative link leads to: a path in the repository, and an anchor."""
    path, _, anchor = link.partition("#")
    joined = posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page
    return joined, anchor


def picture_name(path):
    """One name a picture: Doxygen knows no folders. Of those made for the site it is the name."""
    return path.replace("/", "_") if (ROOT / path).exists() else posixpath.basename(path)


def link_on_site(page, match):
    mark, text, link = match.groups()
    if re.match(r"[a-z]+:", link):
        return match.group()
    path, anchor = target_of(page, link)
    if mark:
        return f"![{text}]({picture_name(path)})"
    if path in PAGES:
        return f"[{text}](@ref {label(path, anchor)})"
    if re.fullmatch(r"include/ccvt/\w+\.h", path):
        return f"[{text}](@ref {posixpath.basename(path)})"
    if (ROOT / path).is_dir():
        return text
    return f'<a href="files/{path}.txt">{text}</a>'


def outside_code(text, change):
    """Applies `change` to what is neither a fenced block nor a code span."""
    parts = re.split(r"(^```.*?^```$|``.+?``|`[^`\n]+(?:\n[^`\n]+)?`)", text, flags=re.M | re.S)
    return "".join(part if i % 2 else change(part) for i, part in enumerate(parts))


def heading_on_site(page, match):
    level, text = match.groups()
    if level == "#":
        return match.group() if PAGES[page] == "index" else f"# {text} {{#{PAGES[page]}}}"
    return f"{level} {text} {{#{label(page, slug(text))}}}"


def markdown(page, text):
    if PAGES[page] in TITLES:
        text = f"# {TITLES[PAGES[page]]}\n{text}"
    text = outside_code(text, lambda part: LINK.sub(lambda m: link_on_site(page, m), part))
    text = outside_code(text, lambda part: re.sub(r"(?<=[\s(])#(?=[a-z])", r"\\#", part))
    fenced = re.split(r"(^```.*?^```$)", text, flags=re.M | re.S)
    for i in range(0, len(fenced), 2):
        # Doxygen takes a code span with a quote in it for a quotation, unless it has two backticks.
        fenced[i] = re.sub(r"(?<!`)`([^`\n]*'[^`\n]*)`(?!`)", r"``\1``", fenced[i])
        fenced[i] = re.sub(r"^(#+) (.+)$", lambda m: heading_on_site(page, m), fenced[i], flags=re.M)
        fenced[i] = re.sub(r"^<!-- site: (.*) -->$", r"\1", fenced[i], flags=re.M)
    return "".join(fenced)


def comment(line):
    line = re.sub(r"(?<![\w`])#(?=[a-zV])", r"\\#", line)
    return line.replace("et al. ", "et al.\\ ")  # where no sentence ends


def header(text):
    lines = text.split("\n")
    if "namespace ccvt {" in lines:
        first = lines.index("namespace ccvt {")
        while first > 0 and lines[first - 1].startswith("///"):
            first -= 1
        blank = first - 1 if lines[first].startswith("///") else lines.index("")
    else:
        blank = lines.index("")
    lines[blank] = "/// \\file"
    last = lines.index("}  // namespace ccvt") if "}  // namespace ccvt" in lines else len(lines)
    lines = [line if i <= last else "" for i, line in enumerate(lines)]
    return "\n".join(comment(line) if "///" in line else line for line in lines)


def all_links():
    """The page and the match of each link outside code."""
    found = []
    for page in PAGES:
        note = functools.partial(lambda at, m: found.append((at, m)) or "", page)
        outside_code((ROOT / page).read_text(), lambda part, note=note: LINK.sub(note, part))
    return found


def files():
    links = [re.search(r'<a href="files/(.*)\.txt"', link_on_site(page, match)) for page, match in all_links()]
    return sorted({link.group(1) for link in links if link})


def copy_pictures(folder):
    for page, match in all_links():
        path, _ = target_of(page, match.group(3))
        if match.group(1) and (ROOT / path).exists():
            shutil.copy(ROOT / path, pathlib.Path(folder) / picture_name(path))


def main():
    if sys.argv[1] == "--files":
        print("\n".join(files()))
        return
    if sys.argv[1] == "--pictures":
        copy_pictures(sys.argv[2])
        return
    path = pathlib.Path(sys.argv[1]).resolve()
    text = path.read_text()
    name = str(path.relative_to(ROOT))
    sys.stdout.write(markdown(name, text) if name in PAGES else header(text))


if __name__ == "__main__":
    main()
