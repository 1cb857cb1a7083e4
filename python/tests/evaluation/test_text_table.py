"""Tables of text."""

import math

import pytest

from c3rt.evaluation.text_table import markdown_table, shortest, shown, text_table

ROWS = [["", "here", "paper"], ["a heading"], ["error [µm]", "1", "20.5"], ["short", "7"]]


def test_the_first_column_is_left_the_others_right_and_a_heading_widens_none():
    assert text_table(ROWS) == ("            here  paper\n"
                                "a heading\n"
                                "error [µm]     1   20.5\n"
                                "short          7\n")


def test_the_same_in_markdown():
    assert markdown_table(ROWS) == ("|  | here | paper |\n"
                                    "| --- | --- | --- |\n"
                                    "| **a heading** |  |  |\n"
                                    "| error [µm] | 1 | 20.5 |\n"
                                    "| short | 7 |  |\n")


def test_numbers_have_four_digits_and_what_is_none_a_dash():
    assert [shown(value) for value in (0.0123456, 123456.0, 1.0, math.nan, math.inf)] == ["0.01235", "1.235e+05", "1", "-", "-"]


@pytest.mark.parametrize("value, text", [(2.0, "2"), (12.5, "12.5"), (0.1, "0.1"), (1e-7, "1e-07"), (3, "3")])
def test_the_shortest_text_gives_the_same_number_again(value, text):
    assert shortest(value) == text and float(text) == value
