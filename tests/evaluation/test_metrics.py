import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import f1_score

from corsmal.errors import ArgumentError
from corsmal.evaluation.metrics import confusion, f1_by_class, joint_classes, mape, mpf1, relative_errors, weighted_f1

pairs = st.lists(st.tuples(st.integers(0, 3), st.integers(-1, 3)), min_size=1, max_size=30)


def plain_f1(truth, predicted, label):
    hits = sum(t == p == label for t, p in zip(truth, predicted, strict=True))
    said, there = predicted.count(label), truth.count(label)
    return 0.0 if hits == 0 else 2 / (said / hits + there / hits)


def test_mpf1_by_hand():
    # Class 0: 2 hits, 2 said, 3 there: 0.8. Class 1: 1 hit, 2 said, 1 there: 2/3. Class 2: said by none, there never.
    assert mpf1([0, 0, 0, 1], [0, 0, 1, 1]) == pytest.approx(100 * (0.8 + 2 / 3) / 2)


def test_mpf1_counts_a_class_that_only_the_predictions_have():
    assert mpf1([0, 0, 0, 0], [0, 0, 0, 3]) == pytest.approx(100 * (2 * 3 / 7) / 2)


def test_class_numbers_may_be_large():
    assert mpf1([0, 2_000_000_000], [0, 1_000_000_000]) == pytest.approx(100 / 3)


@pytest.mark.parametrize("missing", [None, math.nan, -1, pd.NA])
def test_missing_prediction_is_a_wrong_answer_and_no_class(missing):
    assert mpf1([0, 0], [0, missing]) == pytest.approx(100 * 2 / 3)
    assert weighted_f1([0, 0], [0, missing]) == pytest.approx(100 * 2 / 3)


@given(pairs)
def test_f1_agrees_with_its_definition(both):
    truth, predicted = (list(side) for side in zip(*both, strict=True))
    classes = (set(truth) | set(predicted)) - {-1}
    by_class = {label: plain_f1(truth, predicted, label) for label in classes}
    assert mpf1(truth, predicted) == pytest.approx(100 * sum(by_class.values()) / len(classes))
    weighted = sum(truth.count(label) * by_class[label] for label in set(truth)) / len(truth)
    assert weighted_f1(truth, predicted) == pytest.approx(100 * weighted)


@given(pairs)
def test_f1_agrees_with_scikit_learn(both):
    truth, predicted = (list(side) for side in zip(*both, strict=True))
    labels = sorted((set(truth) | set(predicted)) - {-1})
    macro = f1_score(truth, predicted, labels=labels, average="macro", zero_division=0)
    assert mpf1(truth, predicted) == pytest.approx(100 * macro)
    weighted = f1_score(truth, predicted, average="weighted", zero_division=0)
    assert weighted_f1(truth, predicted) == pytest.approx(100 * weighted)
    assert weighted_f1(predicted, truth) == pytest.approx(
        100 * f1_score(predicted, truth, average="weighted", zero_division=0)
    )


@given(pairs, st.integers(0, 1000))
def test_weights_count_recordings_as_often_as_they_say(both, seed):
    weights = np.random.default_rng(seed).integers(0, 4, (3, len(both)))
    truth, predicted = np.array(both).T
    scores, supports = f1_by_class(truth, predicted, weights.astype(float))
    for row, counts in enumerate(weights):
        repeated = (np.repeat(truth, counts), np.repeat(predicted, counts))
        if len(repeated[0]):
            assert 100 * np.nanmean(scores[row]) == pytest.approx(mpf1(*repeated))
        assert supports[row].sum() == counts.sum()


@given(pairs)
def test_confusion_counts_every_pair(both):
    truth, predicted = (list(side) for side in zip(*both, strict=True))
    table = confusion(truth, predicted, ("none", "pasta", "rice", "water"))
    assert table.to_numpy().tolist() == [[both.count((row, column)) for column in (0, 1, 2, 3, -1)] for row in range(4)]


def test_confusion_of_nothing_is_a_table_of_zeros():
    table = confusion([], [], ("a", "b"))
    assert table.columns.tolist() == ["a", "b", "no estimate"]
    assert table.to_numpy().tolist() == [[0, 0, 0], [0, 0, 0]]


def test_mape_by_hand():
    assert mape([110, 80, 300], [100, 100, 100]) == pytest.approx((10 + 20 + 200) / 3)
    np.testing.assert_allclose(relative_errors([110, 80, 300], [100, 100, 100]), [10, -20, 200])


@pytest.mark.parametrize("missing", [None, math.nan, math.inf, -1, -20, pd.NA])
def test_mape_leaves_out_what_has_no_estimate(missing):
    assert mape([110, missing], [100, 100]) == pytest.approx(10)
    assert mape(pd.Series([110, missing], dtype="object"), [100, 100]) == pytest.approx(10)


def test_joint_classes_are_seven_and_the_rest_is_infeasible():
    grid = [(kind, level) for kind in range(4) for level in range(3)]
    joint = joint_classes(*zip(*grid, strict=True))
    feasible = [(0, 0), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2)]
    assert [feasible.index(pair) if pair in feasible else -1 for pair in grid] == joint.tolist()


def test_joint_class_of_a_missing_half_is_infeasible():
    assert joint_classes([0, None, 7, 1], [None, 0, 1, 5]).tolist() == [-1, -1, -1, -1]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mpf1([], []), "truth is empty"),
        (lambda: mpf1([0, 1], [0]), "same length, got 2 and 1"),
        (lambda: mpf1([0, None], [0, 1]), "leave those out whose truth is unknown"),
        (lambda: mpf1([0, 1.5], [0, 1]), "truth must hold class numbers 0, 1, 2 …, got 1.5"),
        (lambda: mpf1([0, 1], [0, math.inf]), "predicted must hold class numbers 0, 1, 2 …, got inf"),
        (lambda: mpf1([0, 1], [0, 1e300]), r"predicted must hold class numbers 0, 1, 2 …, got 1e\+300"),
        (lambda: mpf1(["none"], [0]), "truth must be a list of numbers"),
        (lambda: mpf1([[0, 1]], [0]), "truth must be a list of numbers"),
        (lambda: mpf1(3, [0]), "truth must be a list of numbers"),
        (lambda: mape([1.0], [0.0]), "true must hold positive numbers"),
        (lambda: mape([1.0], [math.nan]), "true must hold positive numbers"),
        (lambda: mape([None, -1], [1.0, 2.0]), "no estimate among 2 values"),
        (lambda: mape([1.0], [1.0, 2.0]), "same length, got 1 and 2"),
        (lambda: confusion([0, 2], [0, 1], ("a", "b")), "classes names 2 classes, got class number 2"),
        (lambda: joint_classes([0], [0, 0]), "same length"),
    ],
)
def test_bad_input_is_one_clear_sentence(call, message):
    with pytest.raises(ArgumentError, match=message):
        call()
