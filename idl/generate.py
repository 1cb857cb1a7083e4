#!/usr/bin/env python3
"""Reads c3rt.idl and writes what follows from it.

    generate.py fields IDL HEADER      C++: every field of every struct by name, every enumerator's word
    generate.py python IDL DIRECTORY   Python: the package c3rt with a class for every type, for the package cyclonedds 11;
                                       a field that is not given is zero
    generate.py topics TABLE FILE      Python: the rows of topics.hpp, for the package's own client

It knows the part of IDL that every client can have, and refuses the rest: names that are keywords of a client's language,
arrays of arrays, types that are not final or not of fixed size. Needs nothing but Python 3.
"""
import re
import sys
from pathlib import Path

# The keywords and reserved words of the languages that clients are written in.
KEYWORDS = {
    "C": """auto break case char const continue default do double else enum extern float for goto if inline int long
        register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
        alignas alignof bool constexpr false nullptr static_assert thread_local true typeof typeof_unqual""",
    "C++": """alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class
        compl concept const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype default
        delete do double dynamic_cast else enum explicit export extern false float for friend goto if inline int long
        mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
        reinterpret_cast requires return short signed sizeof static static_assert static_cast struct switch template this
        thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor
        xor_eq""",
    "Python": """False None True and as assert async await break class continue def del elif else except finally for from
        global if import in is lambda nonlocal not or pass raise return try while with yield match case type print exec""",
    "Rust": """as async await break const continue crate dyn else enum extern false fn for if impl in let loop match mod
        move mut pub ref return self Self static struct super trait true type unsafe use where while abstract become box do
        final gen macro override priv try typeof unsized virtual yield union""",
    "Java": """abstract assert boolean break byte case catch char class const continue default do double else enum extends
        final finally float for goto if implements import instanceof int interface long native new package private
        protected public return short static strictfp super switch synchronized this throw throws transient try void
        volatile while true false null var record yield sealed permits""",
    "C#": """abstract as base bool break byte case catch char checked class const continue decimal default delegate do
        double else enum event explicit extern false finally fixed float for foreach goto if implicit in int interface
        internal is lock long namespace new null object operator out override params private protected public readonly ref
        return sbyte sealed short sizeof stackalloc static string struct switch this throw true try typeof uint ulong
        unchecked unsafe ushort using virtual void volatile while""",
    "TypeScript": """any as async await boolean break case catch class const constructor continue debugger declare default
        delete do else enum export extends false finally for from function get if implements import in instanceof
        interface let module namespace never new null number of package private protected public require return set static
        string super switch symbol this throw true try type typeof undefined unknown var void while with yield""",
    "IDL": """abstract any alias attribute bitfield bitmask bitset boolean case char component connector const consumes
        context custom default double emits enum eventtype exception factory false finder fixed float getraises home
        import in inout interface local long manages map mirrorport module multiple native object octet oneway out port
        porttype primarykey private provides public publishes raises readonly sequence setraises short string struct
        supports switch true truncatable typedef typeid typename typeprefix union unsigned uses valuebase valuetype void
        wchar wstring int8 uint8 int16 int32 int64 uint16 uint32 uint64""",
}
KEYWORDS = {language: set(words.split()) for language, words in KEYWORDS.items()}

KEYWORDS["IDL"] |= {word.capitalize() for word in KEYWORDS["IDL"]}  # IDL does not tell them apart

# IDL -> the marker of the package cyclonedds
NUMBERS = {
    "double": "types.float64", "float": "types.float32", "boolean": "bool", "octet": "types.uint8",
    "short": "types.int16", "unsigned short": "types.uint16", "long": "types.int32", "unsigned long": "types.uint32",
    "long long": "types.int64", "unsigned long long": "types.uint64",
}


class IdlError(Exception):
    """What is wrong, and where."""


class Struct:
    def __init__(self, module, name):
        self.module, self.name, self.fields = module, name, []


class Field:
    def __init__(self, name, kind, size, is_key, line):
        self.name, self.kind, self.size, self.is_key, self.line = name, kind, size, is_key, line


class Document:
    """The types in the order of the text. A kind is a name of NUMBERS, ("string", n) or a declared type's full name."""

    def __init__(self, text, path="IDL"):
        self.path = path
        self.consts, self.typedefs, self.enums, self.structs = {}, {}, {}, {}
        self.order = []  # full names
        text = re.sub(r"//[^\n]*", "", text)
        self.tokens = [(m.group(), text.count("\n", 0, m.start()) + 1)
                       for m in re.finditer(r"[A-Za-z_]\w*|\d+|::|\S", text)]
        self.at = 0
        while self.at < len(self.tokens):
            self._definition("")

    # ---- reading

    def _fail(self, what, line=None):
        if line is None:
            line = self.tokens[min(self.at, len(self.tokens) - 1)][1] if self.tokens else 1
        raise IdlError(f"{self.path}:{line}: {what}")

    def _peek(self):
        return self.tokens[self.at][0] if self.at < len(self.tokens) else ""

    def _take(self, expected=None):
        token = self._peek()
        if not token or (expected is not None and token != expected):
            self._fail(f"expected {expected or 'more'}, got {token or 'the end'}")
        self.at += 1
        return token

    def _name(self):
        line = self.tokens[self.at][1] if self.at < len(self.tokens) else None
        name = self._take()
        if not re.fullmatch(r"[A-Za-z_]\w*", name):
            self._fail(f"expected a name, got {name}", line)
        languages = [language for language, words in KEYWORDS.items() if name in words]
        if languages:
            self._fail(f"{name} is a keyword of {', '.join(languages)}", line)
        return name

    def _definition(self, module):
        line = self.tokens[self.at][1]
        token = self._take()
        if token == "module":
            name = module + self._name()
            self._take("{")
            while self._peek() != "}":
                self._definition(name + "::")
            self._take("}")
            self._take(";")
        elif token == "const":
            self._kind(module)
            name = self._name()
            self._take("=")
            self.consts[module + name] = int(self._take())
            self._take(";")
        elif token == "typedef":
            kind = self._kind(module)
            name = module + self._name()
            self.typedefs[name] = (kind, self._size(module, kind, line))
            self.order.append(name)
            self._take(";")
        elif token == "enum":
            name = module + self._name()
            self._take("{")
            words = [self._name()]
            while self._peek() == ",":
                self._take(",")
                words.append(self._name())
            self._take("}")
            self._take(";")
            self.enums[name] = words
            self.order.append(name)
        elif token == "@":
            annotation = self._take()
            if annotation != "final":
                self._fail(f"expected @final, got @{annotation}", line)
            self._take("struct")
            self._struct(module)
        elif token == "struct":
            self._fail("a struct must be @final", line)
        else:
            self._fail(f"{token} is not in the part of IDL that every client can have", line)

    def _struct(self, module):
        struct = Struct(module, self._name())
        self._take("{")
        while self._peek() != "}":
            line = self.tokens[self.at][1]
            is_key = False
            if self._peek() == "@":
                self._take("@")
                if self._take() != "key":
                    self._fail("expected @key", line)
                is_key = True
            kind = self._kind(module)
            name = self._name()
            struct.fields.append(Field(name, kind, self._size(module, kind, line), is_key, line))
            self._take(";")
        self._take("}")
        self._take(";")
        self.structs[module + struct.name] = struct
        self.order.append(module + struct.name)

    def _kind(self, module):
        line = self.tokens[self.at][1]
        words = []
        while self._peek() in ("unsigned", "long", "short"):
            words.append(self._take())
        if words:
            kind = " ".join(words)
            if kind == "long" and self._peek() == "double" or kind not in NUMBERS:
                self._fail(f"{kind} is no number of every client", line)
            return kind
        token = self._take()
        if token in NUMBERS:
            return token
        if token == "string":
            if self._peek() != "<":
                self._fail("a string needs a bound: a sample is of fixed size", line)
            self._take("<")
            bound = int(self._take())
            self._take(">")
            return ("string", bound)
        while self._peek() == "::":
            token += self._take() + self._take()
        parts = module.split("::")[:-1]
        for depth in range(len(parts), -1, -1):
            full = "::".join(parts[:depth] + [token])
            if full in self.typedefs or full in self.enums or full in self.structs:
                return full
        return self._fail(f"unknown type {token}; known are numbers, bounded strings, enums and structs", line)

    def _size(self, module, kind, line):
        """Elements of an array; None for a single value."""
        if self._peek() != "[":
            return None
        self._take("[")
        token = self._take()
        self._take("]")
        of_arrays = kind in self.typedefs and self.typedefs[kind][1] is not None
        if self._peek() == "[" or of_arrays:
            self._fail("an array of arrays: Cyclone DDS 0.10 and 11 give it two identities; make it flat", line)
        if token.isdigit():
            return int(token)
        parts = module.split("::")[:-1]
        for depth in range(len(parts), -1, -1):
            full = "::".join(parts[:depth] + [token])
            if full in self.consts:
                return self.consts[full]
        return self._fail(f"unknown size {token}", line)


def words_of(enumerators):
    """ROBOT_USER_STOPPED of ROBOT_IDLE, ... -> "user stopped": without what all have in front."""
    prefix = enumerators[0].split("_")
    for name in enumerators:
        parts = name.split("_")
        while prefix != parts[:len(prefix)] or len(parts) == len(prefix):
            prefix = prefix[:-1]
    return [" ".join(name.split("_")[len(prefix):]).lower() for name in enumerators]


def c_name(full):
    return full.replace("::", "_")


# ---- C++

def fields(document):
    """A struct's fields in order, the header first. `visit` is called with a name and a value; for an array of structs
    whose name is the plural of a count before it (knot_count, knots) `visit.list` with the count; for times that the
    machine measured (MachineSeconds) `visit.machine_time`. visit_key is given the fields of the key alone, visit_in_order
    every field's value in the order of the IDL, as it crosses the network."""
    out = ["#pragma once", "// Generated from c3rt.idl by generate.py.", "#include <cstdint>", "#include \"c3rt.h\"", "",
           "namespace c3rt::wire {", ""]
    for full in document.order:
        if full in document.enums:
            names = document.enums[full]
            scope = c_name(full)[:-len(full.split("::")[-1])]
            out.append(f"constexpr std::uint32_t enumerators({c_name(full)}) {{ return {len(names)}; }}")
            out.append(f"constexpr const char* name_of({c_name(full)} value) {{")
            out.append("  switch (value) {")
            for name, word in zip(names, words_of(names)):
                out.append(f"    case {scope}{name}: return \"{word}\";")
            out += ["  }", "  return \"?\";", "}", ""]
        if full not in document.structs:
            continue
        struct = document.structs[full]
        counts = {f.name for f in struct.fields if f.kind == "long" and f.size is None}
        lines = []
        for field in struct.fields:
            name, value = field.name, f"s.{field.name}"
            last = field.kind.split("::")[-1] if isinstance(field.kind, str) else ""
            count = name[:-1] + "_count"
            if field.size is not None and field.kind in document.structs and count in counts:
                lines.append(f"  visit.list(\"{name}\", {value}, s.{count});")
            elif last == "MachineSeconds":
                lines.append(f"  visit.machine_time(\"{name}\", {value});")
            elif name == "header":
                lines.insert(0, f"  visit(\"{name}\", {value});")
            else:
                lines.append(f"  visit(\"{name}\", {value});")
        for qualifier in ("const ", ""):
            out.append("template <typename Visitor>")
            out.append(f"void visit_fields({qualifier}{c_name(full)}& s, Visitor& visit) {{")
            out += lines
            out += ["}", ""]
            out.append("template <typename Visitor>")
            out.append(f"void visit_in_order({qualifier}{c_name(full)}& s, Visitor& visit) {{")
            out += [f"  visit(s.{f.name});" for f in struct.fields]
            out += ["}", ""]
        out.append("template <typename Visitor>")
        out.append(f"void visit_key(const {c_name(full)}& s, Visitor& visit) {{")
        out += [f"  visit(\"{f.name}\", s.{f.name});" for f in struct.fields if f.is_key] or ["  (void)s, (void)visit;"]
        out += ["}", ""]
    out += ["}  // namespace c3rt::wire", ""]
    return "\n".join(out)


# ---- Python

def python_files(document):
    """The text of each module's __init__.py by its path."""
    files = {}
    modules = []
    for full in document.order:
        module = full.rsplit("::", 1)[0]
        if module not in modules:
            modules.append(module)

    def marker(kind):
        if isinstance(kind, tuple):
            return f"types.bounded_str[{kind[1]}]"
        return NUMBERS.get(kind) or f"'{kind.replace('::', '.')}'"

    def annotation(kind, size):
        return marker(kind) if size is None else f"types.array[{marker(kind)}, {size}]"

    def zero(kind):
        """A value in words: 0, "", the first enumerator, a struct of such."""
        if isinstance(kind, tuple):
            return '""'
        if kind in document.typedefs:
            of, size = document.typedefs[kind]
            return zero(of) if size is None else zeros(of, size)
        if kind in document.enums:
            return f"{kind.split('::')[-1]}.{document.enums[kind][0]}"
        if kind in document.structs:
            return f"{kind.split('::')[-1]}()"
        return {"double": "0.0", "float": "0.0", "boolean": "False"}.get(kind, "0")

    def zeros(kind, size):
        shared = kind not in document.structs and not (kind in document.typedefs and document.typedefs[kind][1])
        return f"[{zero(kind)}] * {size}" if shared else f"[{zero(kind)} for _ in range({size})]"

    def default(kind, size):
        value = zero(kind) if size is None else zeros(kind, size)
        return f"field(default_factory=lambda: {value})" if value.endswith(")") or "[" in value else value

    for module in modules:
        out = ["# Generated from c3rt.idl by generate.py, for the package cyclonedds 11.", "from dataclasses import dataclass, field",
               "from enum import auto", "", "import cyclonedds.idl as idl", "import cyclonedds.idl.annotations as annotate",
               "import cyclonedds.idl.types as types", "", "import c3rt", ""]
        for name, value in document.consts.items():
            if name.rsplit("::", 1)[0] == module:
                out.append(f"{name.split('::')[-1]} = {value}")
        for full in document.order:
            scope, name = full.rsplit("::", 1)
            if scope != module:
                continue
            dotted = full.replace("::", ".")
            if full in document.typedefs:
                out += ["", f"{name} = types.typedef['{dotted}', {annotation(*document.typedefs[full])}]"]
            elif full in document.enums:
                out += ["", "", f"class {name}(idl.IdlEnum, typename='{dotted}', default='{document.enums[full][0]}'):"]
                out += [f"    {word} = {i}" for i, word in enumerate(document.enums[full])]
            else:
                struct = document.structs[full]
                out += ["", "", "@dataclass", "@annotate.final", "@annotate.autoid('sequential')",
                        f"class {name}(idl.IdlStruct, typename='{dotted}'):"]
                for field in struct.fields:
                    out.append(f"    {field.name}: {annotation(field.kind, field.size)} = {default(field.kind, field.size)}")
                    if field.is_key:
                        out.append(f"    annotate.key('{field.name}')")
        out += ["", ""]
        folders = module.split("::")
        files["/".join(folders) + "/__init__.py"] = "\n".join(out)
        for depth in range(1, len(folders)):
            imports = [f"from . import {m.split('::')[depth]}" for m in modules
                       if m.split("::")[:depth] == folders[:depth]]
            files.setdefault("/".join(folders[:depth]) + "/__init__.py", "\n".join(imports) + "\n")
    return files


def topics_file(text, path="topics.hpp"):
    """The rows of the table TOPIC(Type, "name", quality, writers, readers, deadline, trait) in its order."""
    rows = re.findall(r'TOPIC\((\w+),\s*"([^"]+)",\s*k(\w+),\s*([^,]+),\s*[^,]+,\s*([0-9.]+),\s*k(\w+)\)', text)
    if len(rows) != len(re.findall(r'\bTOPIC\(\w+,\s*"', text)) or not rows:
        raise IdlError(f"{path}: expected rows TOPIC(Type, \"name\", kQuality, writers, readers, deadline, kTrait)")
    out = ['"""Generated from idl/topics.hpp by idl/generate.py: each topic\'s name, type, quality, its one writer (or ""),',
           'deadline in seconds (or 0), whether it is addressed, and its place in Tick.newest_seq (or -1)."""', "", "ROWS = ("]
    streams = 0
    for kind, name, quality, writers, deadline, trait in rows:
        process = re.fullmatch(r"k(Plant|Impedance|Planner|Vision)", writers.strip())
        stream = -1
        if quality in ("Stream", "Plan"):
            stream, streams = streams, streams + 1
        out.append(f'    ("{name}", "{kind}", "{quality.lower()}", "{process.group(1).lower() if process else ""}", '
                   f'{float(deadline)}, {trait == "Addressed"}, {stream}),')
    return "\n".join(out + [")", ""])


def main(arguments):
    if len(arguments) != 3 or arguments[0] not in ("fields", "python", "topics"):
        print(__doc__, file=sys.stderr)
        return 2
    back_end, source, target = arguments[0], Path(arguments[1]), Path(arguments[2])
    try:
        if back_end == "topics":
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(topics_file(source.read_text(), str(source)))
            return 0
        document = Document(source.read_text(), str(source))
    except (IdlError, OSError) as error:
        print(f"generate.py: {error}", file=sys.stderr)
        return 1
    if back_end == "fields":
        target.write_text(fields(document))
        return 0
    for name, text in python_files(document).items():
        path = target / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
