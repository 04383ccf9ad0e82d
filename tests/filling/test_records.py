import itertools

import numpy as np
import pytest

from corsmal.errors import ArgumentError
from corsmal.filling import FEASIBLE_PAIRS, LEVEL_NAMES, TYPE_NAMES, FillingPrediction, decode

TYPES, LEVELS = np.array([0.0, 1.0, 2.0, -1.0]), np.array([3.0, 1.0, 0.0])


def test_names_are_in_the_order_of_the_dataset():
    assert TYPE_NAMES == ("none", "pasta", "rice", "water")
    assert LEVEL_NAMES == ("empty", "half", "full")


def test_probabilities_are_the_softmax_of_the_logits():
    prediction = FillingPrediction(TYPES, LEVELS)
    powers = [np.e**logit for logit in TYPES]
    np.testing.assert_allclose(prediction.type_probabilities, np.array(powers) / sum(powers))
    np.testing.assert_allclose(prediction.level_probabilities.sum(), 1)
    assert prediction.ok
    assert list(prediction.probabilities) == [*TYPE_NAMES, *LEVEL_NAMES]
    assert prediction.probabilities["rice"] == pytest.approx(powers[2] / sum(powers))


def test_large_logits_do_not_overflow():
    prediction = FillingPrediction(np.array([1000.0, 0, 0, 0]), np.array([0.0, -1000.0, 0]))
    np.testing.assert_allclose(prediction.type_probabilities, [1, 0, 0, 0])
    np.testing.assert_allclose(prediction.level_probabilities, [0.5, 0, 0.5])


def test_independent_decoding_takes_each_heads_best():
    prediction = FillingPrediction(TYPES, LEVELS)
    assert (prediction.filling_type, prediction.filling_level) == (2, 0)  # rice that is empty: the paper allows it


def test_feasible_decoding_takes_the_best_pair_that_exists():
    types, levels = np.log([0.1, 0.2, 0.6, 0.1]), np.log([0.5, 0.3, 0.2])
    # rice half 0.18 is ahead of none empty 0.05; rice empty 0.30 does not exist
    assert FillingPrediction(types, levels).pair == (2, 0)
    assert FillingPrediction(types, levels, decoding="feasible").pair == (2, 1)


def test_feasible_decoding_agrees_with_trying_all_pairs():
    rng = np.random.default_rng(0)
    for _ in range(300):
        types, levels = rng.dirichlet(np.full(4, 0.5)), rng.dirichlet(np.full(3, 0.5))
        best, found = -1.0, None
        for filling, level in itertools.product(range(4), range(3)):
            exists = (filling == 0) == (level == 0)
            if exists and types[filling] * levels[level] > best:
                best, found = types[filling] * levels[level], (filling, level)
        assert decode(types, levels, decoding="feasible") == found
        assert decode(types, levels, decoding="independent") == (int(types.argmax()), int(levels.argmax()))


def test_there_are_seven_pairs():
    assert len(set(FEASIBLE_PAIRS)) == 7


def test_failed_prediction_has_a_reason_and_no_numbers():
    failed = FillingPrediction.failed("there is no sound")
    assert not failed.ok
    assert failed.reason == "there is no sound"
    assert failed.filling_type is failed.filling_level is failed.pair is None
    assert failed.type_probabilities is failed.level_probabilities is None
    assert failed.probabilities == {}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"type_logits": np.zeros(3)}, "type_logits must be"),
        ({"level_logits": np.array([0, np.nan, 0])}, "level_logits must be"),
        ({"level_logits": None}, "level_logits must be given"),
        ({"reason": "broken"}, "type_logits must be given"),
        ({"attention": np.array([0.5, 0.4])}, "attention must sum to 1"),
        ({"attention": np.array([1.5, -0.5])}, "attention must be"),
        ({"attention": np.array([np.nan, 1])}, "attention must be"),
        ({"attention": np.ones((1, 1))}, "attention must be"),
        ({"attention": np.array([0.5, 0.5]), "rows": (0, 3)}, "one value per row"),
        ({"steps_s": 0.0}, "steps_s must be positive"),
        ({"decoding": "best"}, "decoding must be"),
    ],
)
def test_what_is_no_prediction_is_refused(changes, message):
    with pytest.raises(ArgumentError, match=message):
        FillingPrediction(**{"type_logits": TYPES, "level_logits": LEVELS, **changes})
