#!/usr/bin/env python3
"""What docs/site/reference.py makes of the tree, against what the tree itself has.

    reference_test.py BUILD
"""
import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs/site"))

import reference  # noqa: E402

BUILD = Path(sys.argv.pop())


class Reference(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.commands = reference.commands(BUILD)  # some fifty calls of c3rt --help

    def test_every_example_of_a_command_is_below_a_heading_of_its_own(self):
        made = self.commands
        headings = set(re.findall(r"^##+ (c3rt [a-z -]+)$", made, re.MULTILINE))
        examples = (ROOT / "cli/examples.cpp").read_text(encoding="utf-8")
        verbs = {"c3rt " + verb for verb in re.findall(r'"c3rt ([a-z]+)', examples)}
        self.assertGreater(len(verbs), 20)
        self.assertEqual(verbs - headings, set())
        self.assertIn("c3rt target circle", headings)

    def test_a_help_is_printed_as_it_is(self):
        help_text = subprocess.run([BUILD / "bin/c3rt", "run", "--help"], capture_output=True, text=True, check=True).stdout
        self.assertIn(help_text.rstrip(), self.commands)

    def test_every_topic_and_every_type_is_there(self):
        made = reference.topics(BUILD)
        for name in re.findall(r'^  TOPIC\(\w+,\s*"([^"]+)"', (ROOT / "idl/topics.hpp").read_text(encoding="utf-8"), re.MULTILINE):
            self.assertIn(f"\n## {name}\n", made)
        idl = (ROOT / "idl/c3rt.idl").read_text(encoding="utf-8")
        for name in re.findall(r"^(?:@final struct|enum) (\w+)", idl, re.MULTILINE):
            self.assertEqual(len(re.findall(rf"^(?:@final struct|enum) {name} ", made, re.MULTILINE)), 1, name)

    def test_every_public_name_of_the_package_is_there(self):
        made = reference.python(BUILD)
        if not (BUILD / "python/c3rt/_core.pyi").exists():
            self.skipTest("the packages of Python were not to be had")
        for name in re.findall(r'^    "(\w+)",$', (ROOT / "python/c3rt/__init__.py").read_text(encoding="utf-8"), re.MULTILINE):
            self.assertIn(f"\n### {name}\n", made)

    def test_what_a_header_says_of_its_solver_is_there(self):
        made = reference.cpp(BUILD)
        self.assertNotIn("private:", made)
        self.assertIn("\n## c3rt::client\n", made)
        self.assertIn("/// Settings of Algorithm 1. Counts alone decide the answer: no time limit is in here.\nstruct Settings {\n  int admm_iterations;", made)

    def test_every_mark_of_a_page_names_a_part(self):
        marks = []
        for page in (ROOT / "docs").rglob("*.md"):
            marks += re.findall(r"^<!-- made: (\w+) -->$", page.read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(sorted(marks), sorted(reference.PARTS))


if __name__ == "__main__":
    unittest.main()
