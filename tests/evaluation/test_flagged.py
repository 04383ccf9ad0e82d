from pathlib import Path

import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import estimates_table
from corsmal.evaluation.flagged import flag_counts, without_flagged
from corsmal.notes import FLAGS, Note, flags_of, prefixed

TABLE = estimates_table(
    [
        {"recording_id": "000001", "flags": ""},
        {"recording_id": "000002", "flags": "sound-cut"},
        {"recording_id": "000003", "flags": "unit-assumed; sound-cut"},
        {"recording_id": "000004", "flags": "unit-assumed"},
    ]
)


@pytest.mark.parametrize(
    ("flags", "left"),
    [
        ((), "1234"),
        (("sound-cut",), "14"),
        (("unit-assumed", "sound-cut"), "1"),
        (("any",), "1"),
        (("implausible",), "1234"),
    ],
)
def test_flagged_rows_are_left_out_and_named(flags, left):
    table, sentence = without_flagged(TABLE, flags)
    assert [name[-1] for name in table["recording_id"]] == list(left)
    assert (sentence == "") == (left == "1234")
    assert len(left) == 4 or f"{4 - len(left)} of 4 rows raise a flag" in sentence


def test_nothing_left_is_one_sentence():
    with pytest.raises(ArgumentError, match=r"all 3 rows raise a flag \(any\): none is left to evaluate"):
        without_flagged(TABLE.iloc[1:], ["any"])


def test_flags_are_counted():
    assert list(flag_counts(TABLE).items()) == [("any", 3), ("unit-assumed", 2), ("sound-cut", 2)]
    assert flag_counts(TABLE.iloc[:1]) == flag_counts(pd.DataFrame({"recording_id": ["000001"]})) == {}


def test_tables_without_flags_stay_and_unknown_flags_are_refused():
    plain = pd.DataFrame({"recording_id": ["000001"]})
    assert without_flagged(plain, ["any"]) == (plain, "")
    with pytest.raises(ArgumentError, match="flags must be one of detections-interpreted, "):
        without_flagged(TABLE, ["loud"])


def test_sentences_raise_flags_once_and_in_order():
    notes = [
        Note("b", flag="sound-cut"),
        "plain",
        prefixed("x", Note("a", flag="unit-assumed")),
        Note("c", flag="sound-cut"),
    ]
    assert flags_of(notes) == ("unit-assumed", "sound-cut")
    assert notes[2] == "x: a"
    assert prefixed("x", "plain") == "x: plain"
    assert len(FLAGS) < 20, "flags are few"


def test_the_readme_lists_the_flags():
    text = (Path(__file__).resolve().parents[2] / "README.md").read_text(encoding="utf-8")
    assert [line for line in text.splitlines() if line.startswith("| `")][: len(FLAGS)] == [
        f"| `{flag}` | {meaning} |" for flag, meaning in FLAGS.items()
    ]
