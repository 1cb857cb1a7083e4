#!/usr/bin/env python3
"""The pages of the repository: every link leads somewhere, every page of docs/ is on the front page, and what sources
say of pages is so. Needs nothing but Python 3: the site's own check (./c3rt docs) has more, and more that it needs.

    pages_test.py ROOT
"""
import fnmatch
import os
import re
import sys
from pathlib import Path

# sources that a person reads, where a page may be named
SOURCES = ("*.md", "*.cpp", "*.hpp", "*.py", "*.sh", "*.cmake", "CMakeLists.txt", "*.yaml", "*.xml", "*.idl")
HISTORY = "CHANGELOG.md"  # names pages as they were called


def without_code(text):
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^(?: {4}|\t).*$", "", text, flags=re.MULTILINE)
    return re.sub(r"`[^`\n]*`", "", text)


def anchors(text):
    """Of each heading, as a forge and the site name them."""
    found, inside = set(), False
    for line in text.splitlines():
        if line.startswith("```"):
            inside = not inside
        match = None if inside else re.match(r"#+ +(.*?)\s*$", line)
        if match:
            words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match.group(1)).lower()
            found.add(re.sub(r"[^\w\- ]", "", words).replace(" ", "-"))
    return found


def links(text):
    return re.findall(r"\]\((?![a-z]+:)([^)#\s]*)(?:#([^)\s]*))?\)", without_code(text))


def files_of(root, *patterns):
    """The files that a person wrote: nothing that was built or left by a run."""
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(name for name in folders if name not in ("build", "out", ".git"))
        for name in sorted(names):
            if any(fnmatch.fnmatch(name, pattern) for pattern in patterns):
                yield Path(folder) / name


def problems_of(root):
    found = []
    for page in files_of(root, "*.md"):
        text = page.read_text(encoding="utf-8")
        name = page.relative_to(root)
        for target, anchor in links(text):
            file = (page.parent / target) if target else page
            if not file.exists():
                found.append(f"{name}: the link to {target} leads nowhere")
            elif anchor and anchor not in anchors(file.read_text(encoding="utf-8")):
                found.append(f"{name}: {target}#{anchor}: no such heading")
    front = root / "docs/index.md"
    listed = {os.path.normpath(front.parent / target) for target, _ in links(front.read_text(encoding="utf-8"))}
    for page in files_of(root / "docs", "*.md"):
        if page != front and os.path.normpath(page) not in listed:
            found.append(f"docs/index.md: {page.relative_to(root)} is not on it")
    for file in files_of(root, *SOURCES):
        if file.name == HISTORY or file.parent == root / "tests/docs":
            continue
        for named in set(re.findall(r"\bdocs/[a-z0-9_/-]+\.md\b", file.read_text(encoding="utf-8", errors="replace"))):
            if not (root / named).exists():
                found.append(f"{file.relative_to(root)}: names {named}, which is not there")
    return found


def main():
    root = Path(sys.argv[1])
    found = problems_of(root)
    for problem in found:
        print(problem)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
