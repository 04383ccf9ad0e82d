import math

import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.evaluation import filling_confusion_tables, filling_container_table, mpf1, pooled_table, weighted_f1


@pytest.fixture
def predictions():
    """Two seeds on 60 recordings of six containers, some wrong, one without an answer."""
    rng = np.random.default_rng(0)
    pairs = np.array([(0, 0), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2)])
    parts = []
    for seed in (0, 1):
        true = pairs[np.arange(60) % 7]
        said = np.where(rng.random((60, 1)) < 0.3, pairs[rng.integers(0, 7, 60)], true)
        parts.append(
            pd.DataFrame(
                {
                    "recording_id": [f"{number:06d}" for number in range(60)],
                    "container_id": np.arange(60) % 6 + 1,
                    "fold": np.arange(60) % 3,
                    "seed": seed,
                    "true_type": true[:, 0],
                    "true_level": true[:, 1],
                    "predicted_type": said[:, 0],
                    "predicted_level": said[:, 1],
                }
            )
        )
    table = pd.concat(parts, ignore_index=True)
    table.loc[0, ["predicted_type", "predicted_level"]] = -1
    return table


def test_pooled_scores_by_seed_and_over_seeds(predictions):
    table = pooled_table(predictions)
    assert table["seed"].tolist() == ["0", "1", "mean", "std"]
    for row, seed in enumerate((0, 1)):
        own = predictions[predictions["seed"] == seed]
        assert table.loc[row, "filling_type"] == pytest.approx(weighted_f1(own["true_type"], own["predicted_type"]))
        assert table.loc[row, "filling_level"] == pytest.approx(weighted_f1(own["true_level"], own["predicted_level"]))
        together = [10 * own[f"{side}_type"] + own[f"{side}_level"] for side in ("true", "predicted")]
        assert table.loc[row, "joint"] == pytest.approx(weighted_f1(*together))
    for name in ("filling_level", "filling_type", "joint"):
        assert table.loc[2, name] == pytest.approx(table.loc[:1, name].mean())
        assert table.loc[3, name] == pytest.approx(abs(table.loc[0, name] - table.loc[1, name]) / math.sqrt(2))
    assert table["recordings"].tolist()[:3] == [60, 60, 60]


def test_container_scores_and_their_average(predictions):
    table = filling_container_table(predictions)
    assert table["container"].tolist() == [
        "red cup",
        "small white cup",
        "small transparent cup",
        "green glass",
        "wine glass",
        "champagne flute",
        "Average",
    ]
    by_seed = [
        mpf1(own["true_level"], own["predicted_level"])
        for _, own in predictions[predictions["container_id"] == 2].groupby("seed")
    ]
    assert table.loc[1, "filling_level_mpf1"] == pytest.approx(np.mean(by_seed))
    assert table.loc[1, "filling_level_mpf1_std"] == pytest.approx(np.std(by_seed, ddof=1))
    assert table.loc[6, "filling_type_mpf1"] == pytest.approx(table.loc[:5, "filling_type_mpf1"].mean())
    assert table["recordings"].tolist() == [10] * 6 + [60]


def test_confusion_by_kind_sums_over_seeds(predictions):
    tables = filling_confusion_tables(predictions, "filling_type")
    totals = {kind: int(table.to_numpy().sum()) for kind, table in tables.items()}
    assert totals == {"cup": 60, "glass": 60, "box": 0}
    assert tables["cup"]["no estimate"].tolist() == [1, 0, 0, 0]


def test_single_seed_has_no_spread(predictions):
    table = pooled_table(predictions[predictions["seed"] == 0])
    assert table["seed"].tolist() == ["0", "mean", "std"]
    assert math.isnan(table.loc[2, "joint"])


def test_winners_predictions_score_as_published(shared_root):
    """The 2020 winners' GRU: weighted F1 of 75.6 (level) and 91.3 (type), pooled over their three folds."""
    source = pd.read_csv(shared_root / "reference" / "gru_vggish_3fold_predictions.csv")
    annotation = pd.read_csv(shared_root / "ccm" / "train" / "ccm_train_annotation.csv").set_index("id")
    levels, types = (source[source["task"] == task].set_index("id") for task in ("filling_level", "filling_type"))
    table = pd.DataFrame(
        {
            "recording_id": annotation.index,
            "container_id": annotation["container id"],
            "fold": levels["fold"],
            "seed": 0,
            "true_type": annotation["filling type"],
            "true_level": annotation["filling level"],
            "predicted_type": types[["p0", "p1", "p2", "p3"]].to_numpy().argmax(axis=1),
            "predicted_level": levels[["p0", "p1", "p2"]].to_numpy().argmax(axis=1),
        }
    )
    scores = pooled_table(table).iloc[0]
    assert scores["filling_level"] == pytest.approx(75.6, abs=0.05)
    assert scores["filling_type"] == pytest.approx(91.3, abs=0.05)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table[:0], "a table with at least one row"),
        (lambda table: table.drop(columns="seed"), "it lacks 'seed'"),
        (lambda table: pd.concat([table, table[5:6]]), "got 000005 twice for seed 0"),
        (lambda table: table.assign(true_level=-1), "true_level must be a number from 0 to 2"),
        (lambda table: table.assign(predicted_type=4), "predicted_type must be a number from 0 to 3"),
        (lambda table: table.assign(predicted_type=0.5), "predicted_type must hold class numbers"),
    ],
)
def test_bad_input_is_one_clear_sentence(predictions, change, message):
    for function in (pooled_table, filling_container_table, lambda t: filling_confusion_tables(t, "filling_level")):
        with pytest.raises(ArgumentError, match=message):
            function(change(predictions))
    with pytest.raises(ArgumentError, match="quantity must be one of"):
        filling_confusion_tables(predictions, "joint")
