"""Which seeds are run."""

import pytest

from c3rt.evaluation.seeds import parse_seeds
from c3rt.evaluation.status import UsageError


@pytest.mark.parametrize("text, seeds", [
    ("7", [7]),
    ("3..6", [3, 4, 5, 6]),
    ("5..5", [5]),
    ("1,5,9..12", [1, 5, 9, 10, 11, 12]),
    ("9,1..2,0", [9, 1, 2, 0]),
    ("18446744073709551614..18446744073709551615", [2**64 - 2, 2**64 - 1]),
])
def test_seeds_are_numbers_and_ranges_in_the_order_written_both_ends_included(text, seeds):
    assert parse_seeds(text) == seeds


@pytest.mark.parametrize("text", ["", "a", "1,", ",1", "1..", "..4", "1...4", "-1", "1 2", "1.5", "0x10", "18446744073709551616",
                                  "1-5", "1_0", "²"])
def test_what_is_no_list_of_seeds_is_refused_with_the_word_and_with_what_was_expected(text):
    with pytest.raises(UsageError) as error:
        parse_seeds(text)
    assert f'--seeds "{text}"' in str(error.value) and "1,5,9..12" in str(error.value)


@pytest.mark.parametrize("text, says", [
    ("5..2", '"5..2" runs backwards'),
    ("1..4,3", "seed 3 comes twice"),
    ("1..18446744073709551615", "more than 100000"),
])
def test_ranges_that_make_no_sense_are_named(text, says):
    with pytest.raises(UsageError, match=says):
        parse_seeds(text)
