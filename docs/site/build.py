#!/usr/bin/env python3
"""Makes the site of docs/: c3rt docs calls it.

    build.py OUT --build BUILD    the pages in OUT, what is made from the tree by the programs of BUILD (build/release)

Every link is checked; the first that leads nowhere ends it with status 1. Needs what requirements.txt names.
"""
import argparse
import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import reference

ROOT = Path(__file__).resolve().parents[2]
AT_THE_TOP = ("CONTRIBUTING.md", "CHANGELOG.md")  # pages of the site that stand above docs/


def place(path):
    """Where a file of the repository is in the site: docs/ is its top."""
    return path.relative_to("docs") if path.parts[0] == "docs" else path


def with_links_of_the_site(text, path):
    """The page at path, its links to other files of the repository as they are in the site."""

    def link(match):
        target, anchor = match.group(1), match.group(2) or ""
        file = Path(os.path.normpath(path.parent / target))
        if file.parts[0] != "docs" and str(file) not in AT_THE_TOP:
            return match.group(0)  # not in the site: refused by Sphinx
        return f"]({os.path.relpath(place(file), place(path).parent)}{anchor})"

    return re.sub(r"\]\((?![a-z]+:|#)([^)#\s]+)(#[^)\s]*)?\)", link, text)


def gather(source, programs):
    """The pages of the site as Sphinx reads them."""
    files = [file for file in (ROOT / "docs").rglob("*") if file.is_file() and "site" not in file.relative_to(ROOT).parts]
    for file in [*files, *(ROOT / name for name in AT_THE_TOP)]:
        path = file.relative_to(ROOT)
        target = source / place(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        if file.suffix == ".md":
            text = reference.with_parts(file.read_text(encoding="utf-8"), programs)
            target.write_text(with_links_of_the_site(text, path), encoding="utf-8")
        else:
            shutil.copyfile(file, target)


def main():
    parser = argparse.ArgumentParser(description="Makes the site of docs/")
    parser.add_argument("out", type=Path)
    parser.add_argument("--build", type=Path, required=True, help="where the programs were built")
    arguments = parser.parse_args()
    if importlib.util.find_spec("sphinx") is None:
        print("c3rt: error: Sphinx is missing: pip install --requirement docs/site/requirements.txt", file=sys.stderr)
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # Ctrl-C of ./c3rt docs: nothing is left behind
    with tempfile.TemporaryDirectory() as scratch:
        source, made = Path(scratch) / "source", Path(scratch) / "made"
        gather(source, arguments.build)
        print(f"{len(list(source.rglob('*.md')))} pages", flush=True)
        sphinx = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "--color" if sys.stderr.isatty() else "--no-color",
                                 "-c", Path(__file__).parent, "-d", Path(scratch) / "trees", source, made], stderr=subprocess.PIPE, text=True)
        # mistakes by the names that the pages have in the repository
        for name in AT_THE_TOP:
            sphinx.stderr = sphinx.stderr.replace(f"{source}/{name}", name)
        sys.stderr.write(sphinx.stderr.replace(f"{source}/", "docs/"))
        if sphinx.returncode:
            return 1
        # whole or not at all: who reads the old one keeps it until the new one is there
        shutil.rmtree(arguments.out, ignore_errors=True)
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        shutil.move(made, arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
