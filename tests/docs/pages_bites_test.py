#!/usr/bin/env python3
"""The keepers of the pages themselves: what they refuse. Needs nothing but Python 3."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE))

import commands_test  # noqa: E402
import pages_test  # noqa: E402


class Pages(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        (self.root / "docs").mkdir()
        self.write("docs/index.md", "# Front\n\n[a](a.md#what-it-is)\n")
        self.write("docs/a.md", "# A\n\n## What it *is*\n")

    def write(self, name, text):
        (self.root / name).write_text(text, encoding="utf-8")

    def problems(self):
        return pages_test.problems_of(self.root)

    def test_pages_whose_links_lead_somewhere_are_good(self):
        self.assertEqual(self.problems(), [])

    def test_a_link_to_nothing_is_named(self):
        self.write("README.md", "[gone](docs/gone.md)\n")
        self.assertIn("README.md: the link to docs/gone.md leads nowhere", self.problems())

    def test_a_heading_that_is_not_there_is_named(self):
        self.write("docs/a.md", "# A\n")
        self.assertEqual(self.problems(), ["docs/index.md: a.md#what-it-is: no such heading"])

    def test_a_page_that_the_front_page_leaves_out_is_named(self):
        self.write("docs/b.md", "# B\n")
        self.assertEqual(self.problems(), ["docs/index.md: docs/b.md is not on it"])

    def test_a_source_that_names_a_page_of_old_is_named(self):
        self.write("program.cpp", "// docs/old.md\n")
        self.assertEqual(self.problems(), ["program.cpp: names docs/old.md, which is not there"])

    def test_what_looks_like_a_link_in_code_is_none(self):
        self.write("docs/a.md", "# A\n\n## What it is\n\n    [x](y.md)\n\n```\n[x](y.md)\n```\n\n`[x](y.md)`\n")
        self.assertEqual(self.problems(), [])


class Commands(unittest.TestCase):
    def outcome(self, text):
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "page.md"
            page.write_text(text, encoding="utf-8")
            ran = subprocess.run([sys.executable, HERE / "commands_test.py", page, "--programs", folder], capture_output=True, text=True)
            return ran.returncode, ran.stdout + ran.stderr

    def test_a_command_that_works_and_prints_what_the_page_says_is_good(self):
        self.assertEqual(self.outcome("```yaml\n# a.yaml\nb: 1\n```\n```sh\ncat a.yaml\n```\n```text\n# a.yaml\nb: ...\n```\n")[0], 0)

    def test_a_command_that_fails_is_named_by_its_line(self):
        status, said = self.outcome("# Page\n\n```sh\nfalse\ntrue\n```\n")
        self.assertEqual(status, 1)
        self.assertIn("page.md:3: ended with status 1", said)

    def test_what_is_not_printed_is_named(self):
        for expected in ("two\n", "one\ntwo\n", "one\n...\ntwo\n"):
            with self.subTest(expected):
                status, said = self.outcome(f"```sh\necho one; echo three\n```\n\n```text\n{expected}```\n")
                self.assertEqual(status, 1)
                self.assertIn("page.md:5: expected", said)

    def test_lines_may_lie_between_where_the_page_says_so(self):
        self.assertTrue(commands_test.is_printed("one\n...\nthree\n", "zero\none\ntwo\nthree\nfour\n"))
        self.assertFalse(commands_test.is_printed("one\nthree\n", "one\ntwo\nthree\n"))

    def test_what_runs_in_the_background_ends_with_its_block(self):
        status, said = self.outcome("```sh\nsleep 1000 &\nfalse\n```\n")
        self.assertEqual(status, 1)
        self.assertIn("ended with status 1", said)

    def test_a_page_without_commands_is_refused(self):
        self.assertEqual(self.outcome("# Page\n\n    indented\n")[0], 1)

    def test_a_page_in_python_is_skipped_without_python(self):
        self.assertEqual(self.outcome("```sh\npython3 a.py\n```\n")[0], 77)


if __name__ == "__main__":
    unittest.main()
