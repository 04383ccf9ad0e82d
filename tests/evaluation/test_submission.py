import math
import re

import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError, FileError
from corsmal.evaluation import (
    SUBMISSION_COLUMNS,
    challenge_scores,
    read_estimates,
    read_submission,
    submission_table,
    write_submission,
)
from tests.evaluation.made import made_annotation, perfect_estimates

HEADER = (
    "Configuration ID,Container capacity,Container mass,Filling mass,None,Pasta,Rice,Water,Filling type,Empty,"
    "Half-full,Full,Filling level,Width at the top,Width at the bottom,Height,Object safety,Distance,Angle difference,"
    "Execution time"
)


@pytest.fixture
def annotation():
    return made_annotation(6)


@pytest.fixture
def estimates(annotation):
    return perfect_estimates(annotation)


def test_file_as_the_challenge_wants_it(tmp_path, estimates):
    estimates.loc[4, ["capacity_ml", "filling_level", "type_p1"]] = math.nan
    estimates["execution_time_ms"] = [2834.4, *[math.nan] * 5]
    write_submission(submission_table(estimates), tmp_path / "team.csv")
    lines = (tmp_path / "team.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == HEADER
    assert lines[1] == "0,520,10,0,1,0,0,0,0,1,0,0,0,98,61,119,-1,-1,-1,2834"
    assert lines[5] == "4,-1,130,51,0,-1,0,0,1,0,1,0,-1,75,56,88,-1,-1,-1,-1"
    assert len(lines) == 7


def test_columns_are_those_of_the_challenges_own_file(shared_root):
    given = pd.read_csv(shared_root / "reference" / "challenge_random_baseline.csv")
    assert given.columns.tolist() == list(SUBMISSION_COLUMNS)


def test_estimates_scored_as_a_submission_and_through_its_file_are_the_same(tmp_path, annotation, estimates):
    estimates["capacity_ml"] *= 1.23456789
    submission = submission_table(estimates)
    write_submission(submission, tmp_path / "team.csv")
    again = pd.read_csv(tmp_path / "team.csv")
    assert again.columns.tolist() == list(SUBMISSION_COLUMNS)
    np.testing.assert_allclose(again.to_numpy(dtype=float), submission.to_numpy(dtype=float), rtol=1e-9)
    np.testing.assert_allclose(challenge_scores(annotation, again), challenge_scores(annotation, submission))


def test_submission_has_the_wanted_rows_and_minus_one_where_nothing_is_known(estimates):
    table = submission_table(estimates[2:4], recordings=[3, "000002", "000009"])
    assert table["Configuration ID"].tolist() == [3, 2, 9]
    assert table.loc[0, "Height"] == 119
    assert table.iloc[2, 1:].eq(-1).all()


def test_id_that_is_no_number_stays_as_it_is(estimates):
    assert submission_table(estimates[:1].assign(recording_id="cup_a"))["Configuration ID"].tolist() == ["cup_a"]


def test_unusable_estimates_become_minus_one(estimates):
    odd = estimates.astype(object)
    odd.loc[0, "filling_type"], odd.loc[1, "height_mm"], odd.loc[2, "capacity_ml"] = 4, "tall", -3
    table = submission_table(odd)
    assert [table.loc[0, "Filling type"], table.loc[1, "Height"], table.loc[2, "Container capacity"]] == [-1, -1, -1]


def test_file_of_others_with_fewer_columns_is_read_and_scored(tmp_path, annotation):
    (tmp_path / "team.csv").write_text("Configuration ID, Height\n0,119\n1,NaN\n", encoding="utf-8")
    scores = challenge_scores(annotation, pd.read_csv(tmp_path / "team.csv", skipinitialspace=True))
    assert scores["s6"] == pytest.approx(100 / 6)
    assert scores["s3"] == 0
    notes = scores.attrs["notes"]
    assert "submission: there is no column 'Container capacity'; counted as no estimate" in notes


def rewritten(text, separator, decimal):
    return text.replace(",", separator).replace(".", decimal)


OTHERS = {
    "plain": lambda text: text.encode(),
    "trailing commas": lambda text: text.replace("\n", ",\n").replace(",\n", "\n", 1).encode(),
    "a European spreadsheet": lambda text: rewritten(text, ";", ",").encode("cp1252"),
    "Unicode text": lambda text: rewritten(text, "\t", ",").encode("utf-16"),
    "capitals": lambda text: text.replace("Configuration ID", "CONFIGURATION_ID").replace("Height", "height").encode(),
    "an index column": lambda text: "\n".join(
        f"{'' if i == 0 else i - 1},{line}" for i, line in enumerate(text.strip().split("\n"))
    ).encode(),
    "ids as floats": lambda text: re.sub(r"(?m)^(\d+),", r"\1.0,", text).encode(),
}


@pytest.mark.parametrize("kind", list(OTHERS))
def test_submission_of_any_program_scores_the_same(tmp_path, annotation, estimates, kind):
    estimates["capacity_ml"] *= 1.23456789
    submission = submission_table(estimates)
    write_submission(submission, tmp_path / "plain.csv")
    (tmp_path / "team.csv").write_bytes(OTHERS[kind]((tmp_path / "plain.csv").read_text(encoding="utf-8")))
    found = challenge_scores(annotation, read_submission(tmp_path / "team.csv"))
    np.testing.assert_allclose(found, challenge_scores(annotation, submission))
    assert any("team.csv: " in note for note in found.attrs["notes"]) == (kind != "plain")
    as_estimates = read_estimates(tmp_path / "team.csv")
    np.testing.assert_allclose(as_estimates["capacity_ml"], estimates["capacity_ml"], rtol=1e-9)
    assert as_estimates["recording_id"].tolist() == estimates["recording_id"].tolist()


def test_columns_that_pandas_shifted_are_refused(tmp_path, annotation, estimates):
    write_submission(submission_table(estimates), tmp_path / "team.csv")
    (tmp_path / "team.csv").write_bytes(OTHERS["trailing commas"]((tmp_path / "team.csv").read_text(encoding="utf-8")))
    with pytest.raises(ArgumentError, match="as where rows end in a comma; read the file with read_submission"):
        challenge_scores(annotation, pd.read_csv(tmp_path / "team.csv"))
    plain = submission_table(estimates)
    assert challenge_scores(annotation, plain[plain["Height"] > 100])["s6"] > 0


def test_file_that_is_no_submission_is_one_sentence(tmp_path):
    (tmp_path / "a.csv").write_text("Height,Container mass\n1,2\n", encoding="utf-8")
    with pytest.raises(FileError, match="is no submission: it has no column 'Configuration ID' but Height, Container"):
        read_submission(tmp_path / "a.csv")


def test_missing_columns_and_recordings_are_said(tmp_path, estimates):
    with pytest.raises(ArgumentError, match="it lacks 'Rice'"):
        write_submission(submission_table(estimates).drop(columns="Rice"), tmp_path / "team.csv")
    with pytest.raises(ArgumentError, match="estimates: no row is of a recording"):
        submission_table(estimates, recordings=[700])
    with pytest.raises(ArgumentError, match="recording_id"):
        submission_table(pd.DataFrame({"a": [1]}))
