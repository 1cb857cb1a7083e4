#!/usr/bin/env python3
"""The parts of reference pages that are made from the tree, when the site is made: so they cannot be stale.

    reference.py PART --build BUILD    prints one: commands, topics, python or cpp

A page has them where it says <!-- made: PART -->. Needs nothing but Python 3 and what BUILD has.
"""
import argparse
import ast
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def fence(language, text):
    return f"```{language}\n{text.rstrip()}\n```\n"


# ---- c3rt's commands, from --help

def help_of(program, words):
    ran = subprocess.run([program, *words, "--help"], capture_output=True, text=True)
    if ran.returncode != 0:
        raise SystemExit(f"reference.py: {' '.join(map(str, [program, *words]))} --help ended with status {ran.returncode}")
    return ran.stdout


def subcommands(text):
    part = re.search(r"^Subcommands:\n((?:  .*\n?)*)", text, re.MULTILINE)
    return re.findall(r"^  ([a-z][a-z-]*)[ ,]", part.group(1), re.MULTILINE) if part else []


def commands(build):
    program = build / "bin" / "c3rt"
    if not program.exists():
        raise SystemExit(f"reference.py: {program} is not there: ./c3rt build")

    def section(words):
        text = help_of(program, words)
        out = ["#" * min(2 + max(len(words) - 1, 0), 4) + " " + " ".join(["c3rt", *words]), "", fence("text", text)]
        for name in subcommands(text):
            out += section([*words, name])
        return out

    text = help_of(program, [])
    out = [fence("text", text)]
    for name in subcommands(text):
        out += section([name])
    return "\n".join(out)


# ---- topics and types, from idl/

QUALITIES = {"Stream": "stream", "Report": "stream that nobody waits for", "Plan": "plan", "Event": "event",
             "Status": "status", "Sync": "lockstep only"}


def blocks_of_idl(text):
    """Each declaration of the module with the comment above it, by its name."""
    found = {}
    pattern = r"((?:^//[^\n]*\n)*)^((?:@final )?(?:struct|enum) (\w+) \{.*?\};(?:[^\n]*)$)"
    for match in re.finditer(pattern, text, re.MULTILINE | re.DOTALL):
        found[match.group(3)] = match.group(1) + match.group(2)
    return found


def topics(_build):
    types = blocks_of_idl((ROOT / "idl/c3rt.idl").read_text(encoding="utf-8"))
    table = (ROOT / "idl/topics.hpp").read_text(encoding="utf-8")
    rows = re.findall(r'TOPIC\((\w+),\s*"([^"]+)",\s*k(\w+),\s*([^,]+),\s*([^,]+),[^)]*\)\s*/\*\s*(.*?)\s*\*/', table)

    def parties(words):
        return ", ".join(word.strip().removeprefix("k").lower() for word in words.split("|"))

    out = ["| topic | type | writers | readers | rate | kind |", "| --- | --- | --- | --- | --- | --- |"]
    for kind, name, quality, writers, readers, rate in rows:
        out.append(f"| [{name}](#{name.replace('/', '')}) | {kind} | {parties(writers)} | {parties(readers)} | {rate} | "
                   f"{QUALITIES[quality]} |")
    out.append("")
    shown = []
    for kind, name, *_ in rows:
        out += [f"## {name}", "", fence("omg-idl", types[kind])]
        shown.append(kind)
    out += ["## Types that others are made of", ""]
    out += [fence("omg-idl", text) for name, text in types.items() if name not in shown]
    return "\n".join(out)


# ---- Python, from the sources and the extension's stubs

def plain(words):
    """Types as one reads them."""
    words = re.sub(r"Annotated\[NDArray\[numpy\.(\w+)\], dict\([^)]*\)\]", r"NDArray[\1]", words)
    return words.replace("numpy.typing.", "").replace("collections.abc.", "")


def is_shown(name):
    return not name.startswith("_") or name == "__init__"


def entry(function, of=""):
    """How it is called, and what it says of itself."""
    name = of if function.name == "__init__" else (f"{of}." if of else "") + function.name
    function.args.args = [argument for argument in function.args.args if argument.arg not in ("self", "cls")]
    if "property" in decorators(function):
        line = name if function.returns is None else f"{name}: {ast.unparse(function.returns)}"
    else:
        given = "" if function.returns is None or function.name == "__init__" else f" -> {ast.unparse(function.returns)}"
        line = f"{name}({ast.unparse(function.args)}){given}"
    return plain(line), (ast.get_docstring(function) or "").strip()


def decorators(function):
    return [word.id for word in function.decorator_list if isinstance(word, ast.Name)]


def item(line, text):
    return f"- `{line}`" + ("<br>" + text.replace("\n", "\n  ") if text else "")


def described(node):
    out = [f"### {node.name}", ""]
    if isinstance(node, ast.FunctionDef):
        line, text = entry(node)
        out += [f"`{line}`", "", text, ""]
    else:
        out += [ast.get_docstring(node) or "", ""]
        for member in node.body:
            if isinstance(member, ast.FunctionDef) and is_shown(member.name) and "overload" not in decorators(member):
                out.append(item(*entry(member, node.name)))
            elif isinstance(member, ast.AnnAssign) and isinstance(member.target, ast.Name) and is_shown(member.target.id):
                value = f" = {ast.unparse(member.value)}" if member.value is not None else ""
                out.append(item(plain(f"{node.name}.{member.target.id}: {ast.unparse(member.annotation)}{value}"), ""))
        out.append("")
    return out


def names_of(file):
    """A module's __all__, and what it defines."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    public = []
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets):
            public = ast.literal_eval(node.value)
    return tree, public


def definitions(*files):
    found = {}
    for file in files:
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                found.setdefault(node.name, node)
    return found


def python(build):
    package = ROOT / "python/c3rt"
    stubs = build / "python/c3rt/_core.pyi"
    if not stubs.exists():
        return "*This site was made without the Python extension: `help(c3rt)` has the same words.*\n"
    out = []
    modules = [("c3rt", package / "__init__.py", [stubs, package / "_run.py"]),
               ("c3rt.client", package / "client/__init__.py", sorted((package / "client").glob("*.py"))),
               ("c3rt.log", package / "log.py", [package / "log.py"]), ("c3rt.envs", package / "envs.py", [package / "envs.py"]),
               ("c3rt.pictures", package / "pictures/__init__.py", sorted((package / "pictures").glob("*.py")))]
    for name, top, files in modules:
        tree, public = names_of(top)
        found = definitions(*files)
        shown = public or [word for word in found if not word.startswith("_")]
        out += [f"## {name}", "", fence("text", ast.get_docstring(tree) or "")]
        for word in shown:
            if word not in found:
                raise SystemExit(f"reference.py: {name}.{word} is in no source that python() looks at")
            out += described(found[word])
    return "\n".join(out)


# ---- C++, from the headers that are installed

def declarations(text):
    """What stands at the left edge: types with what is public of them, functions with a /// comment above them."""
    text = re.sub(r"^namespace (\w*detail) \{.*?^\}  // namespace \1$", "", text, flags=re.MULTILINE | re.DOTALL)
    found, comment, lines = [], [], text.splitlines()
    at = 0
    while at < len(lines):
        line, begin = lines[at], at
        at += 1
        if line.startswith("///"):
            comment.append(line)
            continue
        head = lines[at] if line.startswith("template") and at < len(lines) else line
        if re.match(r"(struct|class|enum)\b", head) and not re.search(r"\w;$", head):  # no forward declaration
            while not line.endswith("};") and lines[at - 1] != "};":
                at += 1
            body = lines[begin:at]
            if " private:" in body:
                body = "\n".join(body[:body.index(" private:")]).rstrip().splitlines() + ["};"]
            found.append("\n".join(comment + body))
        elif comment and line and not line.startswith((" ", "#", "}")):
            while not re.search(r"[;{]", lines[at - 1]) and at < len(lines):
                at += 1
            found.append("\n".join(comment) + "\n" + re.sub(r"\s*\{.*$", ";", "\n".join(lines[begin:at])))
        comment = []
    return found


def cpp(_build):
    out = []
    text = (ROOT / "cmake/package.cmake").read_text(encoding="utf-8")
    rooms = [(room, "controller/" + room, words)
             for room, words in re.findall(r"^c3rt_export(?:_headers)?\((\w+)\s+HEADERS\s+([^)]*)\)", text, re.MULTILINE)]
    rooms.append(("client", "idl/client", "client.hpp process.hpp planner.hpp estimator.hpp mover.hpp motion.hpp"))
    for room, folder, words in rooms:
        out += [f"## c3rt::{room}", ""]
        for header in (word for word in words.split() if word.endswith(".hpp")):
            shown = declarations((ROOT / folder / header).read_text(encoding="utf-8"))
            if shown:
                out += [f"### {folder}/{header}", "", fence("cpp", "\n\n".join(shown))]
    return "\n".join(out)


PARTS = {"commands": commands, "topics": topics, "python": python, "cpp": cpp}


def with_parts(text, build):
    """A page with the parts that it names."""
    return re.sub(r"^<!-- made: (\w+) -->$", lambda match: PARTS[match.group(1)](build), text, flags=re.MULTILINE)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--build", type=Path, required=True, help="where the programs were built")
    arguments = parser.parse_args()
    sys.stdout.write(PARTS[arguments.part](arguments.build))
