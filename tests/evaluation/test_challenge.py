import itertools
import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError
from corsmal.evaluation import error_table, submission_table
from corsmal.evaluation.challenge import OFFSETS, challenge_scores, overall_score
from tests.evaluation.made import (
    FRACTIONS,
    SCORED,
    made_annotation,
    perfect_estimates,
    perfect_submission,
    random_submission,
)

S1_TO_S8 = [f"s{number}" for number in range(1, 9)]
TASKS = {
    "s1": ["Filling level"],
    "s2": ["Filling type"],
    "s3": ["Container capacity"],
    "dimensions": ["Width at the top", "Width at the bottom", "Height"],
    "s7": ["Container mass"],
}


def plain_scores(annotation, submission, baseline=None, split="train"):
    """The challenge's definitions, one recording after the other."""
    offset = {"train": 0.047505, "public": 0.004339, "private": 0.004338, "other": 0.0}[split]
    truth, estimates = annotation.to_dict("records"), submission.to_dict("records")
    fallback = baseline.to_dict("records") if baseline is not None else None

    def attempted(column):
        return any(row[column] != -1 for row in estimates)

    def weighted_f1(true, predicted):
        total = 0.0
        for label in set(true):
            hits = sum(t == p == label for t, p in zip(true, predicted, strict=True))
            total += true.count(label) * 2 * hits / (true.count(label) + predicted.count(label))
        return total / len(true)

    def mean(formula, column):
        return sum(
            0.0 if row[column] == -1 else formula(row[column], known[SCORED[column]])
            for row, known in zip(estimates, truth, strict=True)
        ) / len(truth)

    def exponential(e, t):
        return math.exp(-abs(e - t) / t) if t else math.exp(-e)

    def linear(e, t):
        return 1 - abs(e - t) / t if abs(e - t) < t else 0.0

    def joint(rows, type_name, level_name):
        feasible = [(0, 0), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2)]
        found = [(row[type_name], row[level_name]) for row in rows]
        return [feasible.index(pair) if pair in feasible else -1 for pair in found]

    def filling_mass():
        mass_tasks = ("Filling level", "Filling type", "Container capacity")
        done = [column for column in mass_tasks if attempted(column)]
        if not done:
            return 0.0
        total, masses = 0.0, 0
        for number, known in enumerate(truth):
            values = {
                column: (estimates if column in done else fallback)[number][column]
                if column in done or fallback
                else -1
                for column in ("Filling level", "Container capacity")
            }
            if -1 in values.values():
                continue
            mass = FRACTIONS[int(values["Filling level"])] * values["Container capacity"] * known["filling density"]
            total += exponential(mass, known["filling mass"])
            masses += 1
        return (total / len(truth) + offset) * len(done) / 3 if masses else 0.0

    s = {
        "s1": weighted_f1([row["filling level"] for row in truth], [row["Filling level"] for row in estimates]),
        "s2": weighted_f1([row["filling type"] for row in truth], [row["Filling type"] for row in estimates]),
        "s3": mean(exponential, "Container capacity"),
        "s4": mean(linear, "Width at the top"),
        "s5": mean(linear, "Width at the bottom"),
        "s6": mean(linear, "Height"),
        "s7": mean(exponential, "Container mass"),
        "s8": filling_mass(),
    }
    s["overall"] = (s["s1"] + s["s2"] + s["s3"] + (s["s4"] + s["s5"] + s["s6"]) / 3 + s["s7"] + s["s8"]) / 8
    s["JFTL"] = weighted_f1(
        joint(truth, "filling type", "filling level"), joint(estimates, "Filling type", "Filling level")
    )
    s["CMD"] = s["s3"] / 2 + (s["s4"] + s["s5"] + s["s6"]) / 6
    return pd.Series(s) * 100


def assert_agree(scores, expected):
    assert scores.index.tolist() == expected.index.tolist()
    np.testing.assert_allclose(scores.to_numpy(), expected.to_numpy(), atol=1e-9)


def attempt(submission, tasks):
    """The submission with −1 in all columns but those of some tasks."""
    left = submission.copy()
    for task, columns in TASKS.items():
        if task not in tasks:
            left[columns] = -1
    return left


@pytest.fixture(scope="module")
def annotation():
    return made_annotation()


@pytest.fixture(scope="module")
def real_annotation(real_dataset_root):
    return pd.read_csv(real_dataset_root / "ccm_train_annotation.csv")


def test_perfect_submission_scores_100_and_75_overall(annotation):
    scores = challenge_scores(annotation, perfect_submission(annotation), split="other")
    assert scores.index.tolist() == [*S1_TO_S8, "overall", "JFTL", "CMD"]
    np.testing.assert_allclose(scores.drop("overall"), 100)
    assert scores["overall"] == pytest.approx(75)
    assert scores.attrs["notes"] == ()


def test_perfect_submission_of_the_training_set_scores_100_in_either_form_of_annotation(
    real_annotation, real_dataset_root
):
    for known in (real_annotation, open_dataset(real_dataset_root).table):
        scores = challenge_scores(known, perfect_submission(real_annotation))
        np.testing.assert_allclose(scores.drop("overall"), 100, atol=1e-4)
        assert scores["overall"] == pytest.approx(75, abs=1e-4)


def test_five_rows_by_hand():
    annotation = pd.DataFrame(
        {
            "id": [0, 1, 2, 3, 4],
            "filling level": [0, 1, 1, 2, 2],
            "filling type": [0, 1, 2, 2, 3],
            "container capacity": [100.0, 200.0, 200.0, 400.0, 500.0],
            "width at the top": [50.0, 50.0, 50.0, 80.0, 80.0],
            "width at the bottom": [40.0, 40.0, 40.0, 60.0, 60.0],
            "height": [100.0] * 5,
            "container mass": [10.0] * 5,
            "filling density": [0.0, 0.34, 0.82, 0.82, 1.0],
            "filling mass": [0.0, 34.0, 82.0, 295.2, 450.0],
        }
    )
    submission = pd.DataFrame(
        {
            "Configuration ID": [0, 1, 2, 3, 4],
            "Filling level": [0, 1, 2, 2, -1],
            "Filling type": [0, 1, 1, 2, 3],
            "Container capacity": [100, 100, 200, -1, 500],
            "Width at the top": [50, 100, 25, 80, -1],
            "Width at the bottom": [-1] * 5,
            "Height": [90, 110, 300, 0, 100],
            "Container mass": [10, 20, 10, 5, -1],
        }
    )
    scores = challenge_scores(annotation, submission)
    # Level F1: 0: 1; 1: 1 hit, 1 said, 2 there = 2/3; 2: 1 hit, 2 said, 2 there = 1/2.
    assert scores["s1"] == pytest.approx(100 * (1 * 1 + 2 * 2 / 3 + 2 / 2) / 5)
    # Type F1: 0: 1; 1: 1 hit, 2 said, 1 there = 2/3; 2: 1 hit, 1 said, 2 there = 2/3; 3: 1.
    assert scores["s2"] == pytest.approx(100 * (1 + 2 / 3 + 2 * 2 / 3 + 1) / 5)
    assert scores["s3"] == pytest.approx(100 * (1 + math.exp(-0.5) + 1 + 0 + 1) / 5)
    assert scores["s4"] == pytest.approx(100 * (1 + 0 + 0.5 + 1 + 0) / 5)
    assert scores["s5"] == 0
    assert scores["s6"] == pytest.approx(100 * (0.9 + 0.9 + 0 + 0 + 1) / 5)
    assert scores["s7"] == pytest.approx(100 * (1 + math.exp(-1) + 1 + math.exp(-0.5) + 0) / 5)
    # Masses: 0 of 0, 17 of 34, 147.6 of 82, none, none.
    assert scores["s8"] == pytest.approx(100 * ((1 + math.exp(-0.5) + math.exp(-0.8)) / 5 + 0.047505))
    assert scores["CMD"] == pytest.approx(scores["s3"] / 2 + (scores["s4"] + scores["s6"]) / 6)
    # Joint: nothing, half pasta, (pasta, full for rice, half), full rice, (−1 for full water).
    assert scores["JFTL"] == pytest.approx(100 * (1 + 1 + 0 + 1 + 0) / 5)
    six = scores[["s1", "s2", "s3", "s7", "s8"]].sum() + (scores["s4"] + scores["s6"]) / 3
    assert scores["overall"] == pytest.approx(six / 8)


@pytest.mark.parametrize(
    "tasks", [some for n in range(len(TASKS) + 1) for some in itertools.combinations(TASKS, n)], ids="+".join
)
@pytest.mark.parametrize("has_baseline", [True, False])
def test_every_subset_of_tasks(annotation, tasks, has_baseline):
    rng = np.random.default_rng(len(tasks))
    baseline = random_submission(annotation, rng) if has_baseline else None
    submission = attempt(perfect_submission(annotation), tasks)
    scores = challenge_scores(annotation, submission, baseline, "other")
    assert_agree(scores, plain_scores(annotation, submission, baseline, "other"))
    for task in ("s1", "s2", "s3", "s7"):
        assert scores[task] == pytest.approx(100 if task in tasks else 0)
    for task in ("s4", "s5", "s6"):
        assert scores[task] == pytest.approx(100 if "dimensions" in tasks else 0)
    mass_tasks = {"s1", "s2", "s3"} & set(tasks)
    if mass_tasks == {"s1", "s2", "s3"}:
        assert scores["s8"] == pytest.approx(100)
    if not mass_tasks:
        assert scores["s8"] == 0


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.sampled_from(list(OFFSETS)), st.booleans(), st.sets(st.sampled_from(list(TASKS))))
def test_random_submissions_agree_with_the_plain_definitions(seed, split, has_baseline, tasks):
    rng = np.random.default_rng(seed)
    annotation = made_annotation(int(rng.integers(1, 60)))
    submission = attempt(random_submission(annotation, rng), tasks)
    baseline = random_submission(annotation, rng) if has_baseline else None
    scores = challenge_scores(annotation, submission, baseline, split)
    assert_agree(scores, plain_scores(annotation, submission, baseline, split))


def test_random_baseline_of_the_challenge_agrees_with_the_plain_definitions(real_annotation, shared_root):
    baseline = pd.read_csv(shared_root / "reference" / "challenge_random_baseline.csv")
    rng = np.random.default_rng(5)
    for submission in (baseline, *(random_submission(real_annotation, rng) for _ in range(5))):
        for tasks in (TASKS, {"s1", "s7"}, {"s2", "dimensions"}):
            tried = attempt(submission, tasks)
            scores = challenge_scores(real_annotation, tried, baseline)
            assert_agree(scores, plain_scores(real_annotation, tried, baseline))


def test_order_of_rows_and_columns_does_not_matter(annotation):
    submission = random_submission(annotation, np.random.default_rng(3))
    expected = challenge_scores(annotation, submission)
    shuffled = submission.sample(frac=1, random_state=1)[submission.columns[::-1]]
    pd.testing.assert_series_equal(challenge_scores(annotation, shuffled), expected)
    pd.testing.assert_series_equal(challenge_scores(annotation.sample(frac=1, random_state=2), submission), expected)


def test_inputs_are_left_as_they_were(annotation):
    submission = random_submission(annotation, np.random.default_rng(4))
    kept, known = submission.copy(), annotation.copy()
    challenge_scores(annotation, submission, submission)
    pd.testing.assert_frame_equal(submission, kept)
    pd.testing.assert_frame_equal(annotation, known)


def test_what_is_unusable_counts_as_minus_one_and_is_said(annotation):
    submission = perfect_submission(annotation).astype(object)
    submission.loc[0, "Filling level"] = 5
    submission.loc[1, "Filling type"] = 1.5
    submission.loc[2, "Height"] = math.nan
    submission.loc[3, "Container mass"] = "heavy"
    submission.loc[4, "Container capacity"] = math.inf
    plain = perfect_submission(annotation)
    for row, name in enumerate(("Filling level", "Filling type", "Height", "Container mass", "Container capacity")):
        plain.loc[row, name] = -1
    scores = challenge_scores(annotation, submission)
    assert_agree(scores, plain_scores(annotation, plain))
    notes = " ".join(scores.attrs["notes"])
    assert "'Filling level' is unusable for recording 000000; counted as no estimate" in notes
    assert "'Container mass' is unusable for recording 000003" in notes


def test_missing_rows_columns_and_repeated_rows_are_said(annotation):
    submission = perfect_submission(annotation).drop(columns="Height")
    submission = pd.concat([submission[2:], submission[5:6], submission[6:7].assign(**{"Configuration ID": 900})])
    scores = challenge_scores(annotation, submission, split="other")
    assert scores["s6"] == 0
    assert scores["s3"] == pytest.approx(100 * 40 / 42)
    assert scores.attrs["notes"] == (
        "submission: recording 000005 appears more than once; the first row was taken",
        "submission: the annotation does not have recording 000900; left out",
        "submission: there is no row for recordings 000000, 000001; counted as no estimate",
        "submission: there is no column 'Height'; counted as no estimate",
    )


def test_annotation_without_truth_gives_what_can_be_computed(annotation):
    submission = perfect_submission(annotation)
    scores = challenge_scores(annotation[["id", "container id"]], submission)
    assert scores.isna().all()
    assert any("there is no truth of filling_level; what needs it is not scored" in n for n in scores.attrs["notes"])
    scores = challenge_scores(annotation.drop(columns=["filling level", "filling mass"]), submission, split="other")
    assert scores[["s1", "s8", "overall", "JFTL"]].isna().all()
    np.testing.assert_allclose(scores[["s2", "s3", "s4", "s5", "s6", "s7", "CMD"]], 100)


def test_recordings_whose_truth_is_unknown_are_left_out(annotation):
    known = annotation.copy()
    known.loc[0, "height"] = -1
    submission = perfect_submission(annotation)
    submission["Height"] = 0.5 * submission["Height"]
    scores = challenge_scores(known, submission)
    assert scores["s6"] == pytest.approx(50)
    assert "annotation: there is no height_mm of recording 000000; left out where it is needed" in scores.attrs["notes"]


def test_overall_takes_tables_and_is_75_at_most_without_the_simulator():
    table = pd.DataFrame({name: [100.0, 0.0] for name in S1_TO_S8})
    assert overall_score(table).tolist() == [75.0, 0.0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"submission": 3}, "submission must be a pandas DataFrame, got int"),
        ({"annotation": None}, "annotation must be a pandas DataFrame, got NoneType"),
        ({"annotation": pd.DataFrame({"id": []})}, "annotation has no rows"),
        ({"annotation": pd.DataFrame({"id": [1, 1]})}, "one row per recording id, got 000001"),
        ({"annotation": pd.DataFrame({"id": [1, None]})}, "got a row without an id"),
        ({"annotation": pd.DataFrame({"name": [1]})}, "annotation must have a column 'recording_id', got name"),
        ({"submission": pd.DataFrame({"Height": [1]})}, "must have a column 'Configuration ID', got Height"),
        (
            {"submission": pd.DataFrame({"Configuration ID": [900]})},
            "submission: no row is of a recording of the annotation",
        ),
        ({"baseline": pd.DataFrame()}, "baseline must have a column 'Configuration ID', got no columns"),
        ({"split": "test"}, "split must be one of train, public, private, other, got 'test'"),
    ],
)
def test_bad_input_is_one_clear_sentence(annotation, change, message):
    arguments = {"annotation": annotation, "submission": perfect_submission(annotation)} | change
    with pytest.raises(ArgumentError, match=message):
        challenge_scores(**arguments)


def test_a_part_is_scored_as_such_beside_how_much_is_missing_and_the_challenge_counts_the_rest_zero(real_annotation):
    one = perfect_submission(real_annotation)[:1]
    part = challenge_scores(real_annotation, one, absent="skip")
    np.testing.assert_allclose(part.drop("overall"), 100)
    assert part["overall"] == pytest.approx(75)
    assert "1 of the annotation's 684 recordings have a row and are scored; 683 have none" in part.attrs["notes"][0]
    whole = challenge_scores(real_annotation, one)
    assert whole["overall"] < 1
    assert (whole.attrs["is_whole"], part.attrs["is_whole"]) == (True, False)


def test_offset_of_a_part_is_what_perfect_estimates_of_it_lack(real_annotation):
    for rows in (slice(0, 3), slice(100, 400)):
        scores = challenge_scores(real_annotation, perfect_submission(real_annotation)[rows], absent="skip")
        assert scores["s8"] == pytest.approx(100)
    without = challenge_scores(real_annotation, perfect_submission(real_annotation)[:400], split="other", absent="skip")
    assert without["s8"] < 97


def test_absent_recordings_are_skipped_or_zero_in_every_score(annotation):
    half = perfect_submission(annotation)[::2]
    np.testing.assert_allclose(
        challenge_scores(annotation, half, split="other", absent="skip"),
        challenge_scores(annotation[::2], half, split="other"),
    )
    assert challenge_scores(annotation, half, split="other")["s3"] == pytest.approx(50)
    with pytest.raises(ArgumentError, match="absent must be one of zero, skip, got 'mean'"):
        challenge_scores(annotation, half, absent="mean")


def test_recordings_that_were_not_filmed_are_scored_by_what_was_heard(annotation):
    estimates = perfect_estimates(annotation)
    unseen = [3, 4, 5]
    estimates.loc[unseen, "status"] = "absent"
    estimates.loc[unseen, ["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "container_mass_g"]] = -1
    errors = error_table(estimates, annotation)
    skipped, zero = (
        challenge_scores(annotation, submission_table(estimates), split="other", absent=absent, errors=errors)
        for absent in ("skip", "zero")
    )
    np.testing.assert_allclose(skipped.drop("overall"), 100)
    assert "3 of 42 recordings were not filmed" in skipped.attrs["notes"][0]
    assert zero["s3"] == pytest.approx(100 * 39 / 42)
    assert zero["s1"] == 100
