"""generate.py: what every client can have is let through, everything else is refused with its place and reason.

    generate_test.py [-v]
"""
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "idl"))
sys.dont_write_bytecode = True
import generate  # noqa: E402


def read(body):
    return generate.Document("module m {\n" + body + "\n};")


def struct(fields):
    return read("@final struct S {\n" + fields + "\n};")


class Refusals(unittest.TestCase):
    def refused(self, why, body):
        with self.assertRaisesRegex(generate.IdlError, why):
            read(body)

    def test_names_that_are_keywords_of_a_client_s_language(self):
        keywords = {"C": "register", "C++": "co_await", "Python": "lambda", "Rust": "impl", "Java": "synchronized",
                    "C#": "stackalloc", "TypeScript": "undefined", "IDL": "factory"}
        self.assertEqual(set(keywords), set(generate.KEYWORDS))
        for language, word in keywords.items():
            why = f"IDL:[23]: {word} is a keyword of .*{language.replace('+', '[+]')}"
            with self.subTest(language):
                self.refused(why, f"@final struct S {{\ndouble {word}; }};")
                self.refused(why, f"\n@final struct {word} {{ double x; }};")
                self.refused(why, f"\nenum {word} {{ A, B }};")
                self.refused(why, f"\nenum E {{ A, {word} }};")
                self.refused(why, f"\nconst long {word} = 1;")
                self.refused(why, f"\ntypedef double {word};")
                self.refused(why, f"\nmodule {word} {{ const long N = 1; }};")

    def test_arrays_of_arrays(self):
        self.refused("IDL:3: an array of arrays", "@final struct S {\ndouble x[2][3]; };")
        self.refused("IDL:3: an array of arrays", "typedef double Vec3[3]; @final struct S {\nVec3 x[2]; };")
        self.refused("IDL:3: an array of arrays", "typedef double Vec3[3];\ntypedef Vec3 Path[2];")

    def test_what_has_no_fixed_size_or_can_change(self):
        self.refused("a string needs a bound", "@final struct S { string x; };")
        self.refused("expected more, got <|unknown type sequence", "@final struct S { sequence<double> x; };")
        self.refused("must be @final", "struct S { double x; };")
        self.refused("expected @final, got @mutable", "@mutable struct S { double x; };")
        self.refused("unknown type Other", "@final struct S { Other x; };")
        self.refused("unknown size N", "@final struct S { double x[N]; };")
        self.refused("union is not in the part of IDL", "union U switch (long) { case 1: double x; };")

    def test_no_more_than_that(self):
        document = struct("double x; long y[3]; string<31> z; @key unsigned long long k;")
        fields = [(f.name, f.kind, f.size, f.is_key) for f in document.structs["m::S"].fields]
        self.assertEqual(fields, [("x", "double", None, False), ("y", "long", 3, False),
                                  ("z", ("string", 31), None, False), ("k", "unsigned long long", None, True)])


class Contract(unittest.TestCase):
    def test_the_contract_is_let_through(self):
        document = generate.Document((ROOT / "idl/c3rt.idl").read_text(), "idl/c3rt.idl")
        self.assertGreater(len(document.structs), 15)

    def test_with_one_bad_line_more_it_is_not(self):
        text = (ROOT / "idl/c3rt.idl").read_text()
        last = text.rindex("};\n\n};")
        for line, why in [("double lambda;", "lambda is a keyword of Python"), ("double x[2][3];", "an array of arrays")]:
            with self.assertRaisesRegex(generate.IdlError, why):
                generate.Document(text[:last] + line + text[last:])


class Topics(unittest.TestCase):
    def test_the_rows_are_those_of_the_table_in_its_order(self):
        text = (ROOT / "idl/topics.hpp").read_text()
        rows = {}
        exec(generate.topics_file(text), rows)
        by_name = {row[0]: row[1:] for row in rows["ROWS"]}
        self.assertEqual(by_name["robot/state"][:4], ("RobotState", "stream", "plant", 0.02))
        self.assertEqual(by_name["sim/done"][1:3], ("sync", ""))
        self.assertTrue(by_name["sim/tick"][4])
        streams = [row[-1] for row in rows["ROWS"] if row[-1] >= 0]
        constants = generate.Document((ROOT / "idl/c3rt.idl").read_text()).consts
        self.assertEqual(streams, list(range(len(streams))))
        self.assertLessEqual(len(streams), constants["c3rt::v2::TOPIC_COUNT"])

    def test_a_row_that_is_not_understood_is_refused(self):
        row = 'TOPIC(A, "a", kStream, kPlant, kAll, 0.0, kNone)'
        generate.topics_file(row)
        for text in ("", row + ' TOPIC(B, "b", kStream, kPlant, kAll)'):
            with self.assertRaisesRegex(generate.IdlError, "topics.hpp: expected rows TOPIC"):
                generate.topics_file(text)


class Words(unittest.TestCase):
    def test_a_word_is_what_is_left_without_what_all_begin_with(self):
        self.assertEqual(generate.words_of(["ROBOT_IDLE", "ROBOT_USER_STOPPED"]), ["idle", "user stopped"])


if __name__ == "__main__":
    unittest.main()
