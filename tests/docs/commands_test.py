#!/usr/bin/env python3
"""The commands of a tutorial or how-to page, typed one after the other by a stranger in one folder.

    commands_test.py PAGE --programs DIRECTORY [--python PROGRAM] [--package DIRECTORY]

A block ```sh is run; a block ```python or ```yaml whose first line is a comment with a file's name is that file; a block ```text right after
a ```sh is what that prints, line by line, where ... stands for anything. examples/, config/ and docs/ are there as in a checkout. A page
that uses python3 or searches is skipped (77) where PROGRAM, with the package and numpy, is not to be had. `--domain 7` becomes a domain of the test's own.
Needs nothing but Python 3.
"""
import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from own_domain import take_domain  # noqa: E402

SKIPPED = 77
DOMAIN = take_domain()
PATIENCE = 240  # of a busy machine, for one block [s]


def blocks_of(text):
    """(language, text, line) of each block between fences."""
    found, inside = [], None
    for number, line in enumerate(text.splitlines(), 1):
        if inside is None and line.startswith("```"):
            inside = (line[3:].strip(), [], number)
        elif inside is not None and line == "```":
            found.append((inside[0], "\n".join(inside[1]) + "\n", inside[2]))
            inside = None
        elif inside is not None:
            inside[1].append(line)
    if inside is not None:
        raise SystemExit(f"line {inside[2]}: the block has no end")
    return found


def is_printed(expected, printed):
    """Whether the lines expected come in this order, with nothing between them where no line of ... is."""

    def pattern(line):
        return ".*".join(re.escape(part) for part in line.rstrip().split("..."))

    whole = ""
    for line in expected.splitlines():
        whole += r"(?:.*\n)*?" if line.strip() == "..." else pattern(line) + r"\s*\n"
    return re.search("^" + whole, printed, re.MULTILINE) is not None


def shims(folder, arguments):
    """python3 as the page means it: with the package."""
    folder.mkdir()
    if arguments.python:
        shim = folder / "python3"
        shim.write_text(f'#!/bin/sh\nPYTHONPATH="{arguments.package}" PYTHONDONTWRITEBYTECODE=1 exec "{arguments.python}" "$@"\n')
        shim.chmod(0o755)


def run(block, folder, environment):
    """Its status and what it prints; whatever it started in the background ends with it."""
    with tempfile.TemporaryFile("w+") as printed:  # no pipe: what is in the background would keep it open
        process = subprocess.Popen(["bash", "-e", "-c", block], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                                   stdout=printed, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            status = process.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            status = f"none after {PATIENCE} s"
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()
        printed.seek(0)
        return status, printed.read()


def follow(blocks, folder, environment, page):
    printed, last = "", None
    for language, block, line in blocks:
        block = block.replace("--domain 7", f"--domain {DOMAIN}")
        where = f"{page}:{line}"
        if language == "sh":
            status, printed = run(block, folder, environment)
            if status != 0:
                print(f"{where}: ended with status {status}:\n{block}\n{printed}")
                return 1
        elif language in ("python", "yaml"):
            name = re.match(r"# ([a-z_]+\.(?:py|yaml))\n", block)
            if not name:
                print(f"{where}: expected a comment with the file's name in the first line")
                return 1
            (folder / name.group(1)).write_text(block, encoding="utf-8")
        elif language == "text" and last == "sh":
            if not is_printed(block, printed):
                print(f"{where}: expected\n{block}\ngot\n{printed}")
                return 1
        last = language
    print(f"{page}: done")
    return 0


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("page", type=Path)
    parser.add_argument("--programs", type=Path, required=True)
    parser.add_argument("--python", default="")
    parser.add_argument("--package", default="")
    arguments = parser.parse_args()
    text = arguments.page.read_text(encoding="utf-8")
    blocks = blocks_of(text)
    commands = [block for block in blocks if block[0] == "sh"]
    if not commands:
        print(f"{arguments.page}: no block of commands: has its form changed?")
        return 1
    if any("python3" in block[1] or "c3rt tune" in block[1] for block in commands) and not os.access(arguments.python, os.X_OK):
        print("the packages of Python were not to be had")
        return SKIPPED
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "checkout"
        folder.mkdir()
        for name in ("config", "docs", "examples"):
            (folder / name).symlink_to(ROOT / name)
        shims(Path(scratch) / "bin", arguments)
        (Path(scratch) / "runtime").mkdir(mode=0o700)
        environment = dict(os.environ, PATH=f"{scratch}/bin:{arguments.programs}:{os.environ['PATH']}",
                           C3RT_PROGRAM=str(arguments.programs / "c3rt"), XDG_RUNTIME_DIR=f"{scratch}/runtime")
        try:
            return follow(blocks, folder, environment, arguments.page.name)
        finally:  # a service that a page's failure has left
            if any("c3rt up" in block[1] for block in commands):
                run(f"c3rt down --domain {DOMAIN}", folder, environment)


if __name__ == "__main__":
    sys.exit(main())
