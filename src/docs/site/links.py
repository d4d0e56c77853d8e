#!/usr/bin/python3
"""Checks the links of the site, and those of the Markdown files in the repository.

Of links within, that what they lead to is there, anchors too; in Markdown anchors are those that Git
hosts make of headings. Of links to other places, their form alone: nothing is fetched.

usage: links.py HTML
"""

import html.parser
import pathlib
import re
import sys
import urllib.parse

from filter import LINK, ROOT, outside_code, slug, target_of

OUTSIDE = re.compile(r"(https?://[a-z0-9.-]+\.[a-z]+(/\S*)?|mailto:\S+@\S+)$", re.I)


class Page(html.parser.HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = [], {""}
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if value is None:
                continue
            if name in ("href", "src") or (name == "data" and tag == "object"):
                self.links.append(value)
            if name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)

    handle_startendtag = handle_starttag


def check_site(folder):
    pages = {path: Page(path) for path in sorted(folder.rglob("*.html"))}
    for path, page in pages.items():
        for link in page.links:
            if link.startswith(("javascript:", "data:")):
                continue
            if re.match(r"[a-z]+:", link, re.I):
                yield (path, link, bool(OUTSIDE.match(link)))
                continue
            name, _, anchor = link.partition("#")
            target = (path.parent / urllib.parse.unquote(name.partition("?")[0])).resolve() if name else path
            there = target.is_file() and (target not in pages or urllib.parse.unquote(anchor) in pages[target].anchors)
            yield (path, link, there)


def check_menus(folder):
    """What the scripts of the menu and of the tree at the side lead to."""
    for script in (folder / "menudata.js", folder / "navtreedata.js"):
        for link in re.findall(r'"(@ref [^"]*|[\w./-]+\.html)(?:#\w+)?"', script.read_text()):
            yield (script, link, (folder / link).is_file())


def anchors_of(path):
    text = re.sub(r"^```.*?^```$", "", path.read_text(), flags=re.M | re.S)
    return {slug(heading) for heading in re.findall(r"^#+ (.+)$", text, flags=re.M)}


def check_markdown():
    folders = ("benchmarks", "cmake", "include", "src", "tests")
    listed = [*ROOT.glob("*.md"), *(path for folder in folders for path in (ROOT / folder).rglob("*.md"))]
    for name in sorted(str(path.relative_to(ROOT)) for path in listed):
        links = []
        outside_code((ROOT / name).read_text(), lambda part: LINK.sub(lambda m: links.append(m.group(3)) or "", without_site(part)))
        for link in links:
            if re.match(r"[a-z]+:", link, re.I):
                yield (name, link, bool(OUTSIDE.match(link)))
                continue
            path, anchor = target_of(name, link)
            target = ROOT / path
            there = target.exists() and (not anchor or (target.suffix == ".md" and anchor in anchors_of(target)))
            yield (name, link, there)


def without_site(text):
    """What a Git host shows: lines for the site are comments there."""
    return re.sub(r"^<!-- site: .*$", "", text, flags=re.M)


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    checked = [*check_site(folder), *check_menus(folder), *check_markdown()]
    dead = [(where, link) for where, link, fine in checked if not fine]
    for where, link in dead:
        print(f"{where}: leads nowhere: {link}")
    print(f"links: {len(checked)} checked, {len(dead)} dead")
    return 1 if dead or len(checked) < 1000 else 0


if __name__ == "__main__":
    sys.exit(main())
