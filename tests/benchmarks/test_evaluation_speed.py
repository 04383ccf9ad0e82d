"""Judging a run of the size of the training set. Compare the rows of one run."""

import numpy as np
import pandas as pd
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from sklearn.metrics import confusion_matrix, f1_score

from corsmal.evaluation import (
    challenge_scores,
    compare_runs,
    confusion_tables,
    container_table,
    error_table,
    submission_table,
)
from corsmal.quantities import QUANTITIES
from tests.evaluation.made import made_annotation, perfect_estimates

RECORDINGS, RESAMPLES = 684, 2000
CLASSES = ("filling_type", "filling_level")

judging = pytest.mark.benchmark(group="tables", max_time=0.5)
scoring = pytest.mark.benchmark(group="challenge", max_time=0.4)
comparing = pytest.mark.benchmark(group="comparison", max_time=0.5)


@pytest.fixture(scope="module")
def annotation() -> pd.DataFrame:
    """As many recordings and containers as the training set has."""
    annotation = made_annotation(RECORDINGS)
    annotation["container id"] = np.arange(RECORDINGS) % 9 + 1
    return annotation


@pytest.fixture(scope="module")
def estimates(annotation: pd.DataFrame) -> pd.DataFrame:
    rng = np.random.default_rng(0)
    estimates = perfect_estimates(annotation)
    estimates["capacity_ml"] *= rng.uniform(0.5, 2, RECORDINGS)
    return estimates.assign(filling_type=rng.integers(0, 4, RECORDINGS), filling_level=rng.integers(0, 3, RECORDINGS))


@pytest.fixture(scope="module")
def errors(annotation: pd.DataFrame, estimates: pd.DataFrame) -> pd.DataFrame:
    return error_table(estimates, annotation)


@judging
def test_all_tables_of_684_recordings(
    benchmark: BenchmarkFixture, annotation: pd.DataFrame, estimates: pd.DataFrame
) -> None:
    def tables() -> list[pd.DataFrame]:
        errors = error_table(estimates, annotation)
        confusions = [table for name in CLASSES for table in confusion_tables(errors, name).values()]
        return [container_table(errors), *confusions]

    assert len(benchmark(tables)) == 7


@judging
def test_bare_means_by_pandas_and_confusions_by_scikit(benchmark: BenchmarkFixture, errors: pd.DataFrame) -> None:
    columns = [quantity.error_column for quantity in QUANTITIES if not quantity.is_class]
    classes = [(errors[f"{name}_true"].to_numpy(int), errors[name].to_numpy(int)) for name in CLASSES]

    def tables() -> list[object]:
        means = errors[columns].abs().groupby(errors["container_id"]).mean()
        return [means, *[confusion_matrix(*pair) for pair in classes]]

    assert len(benchmark(tables)) == 3


@scoring
def test_challenge_scores_of_684_recordings(
    benchmark: BenchmarkFixture, annotation: pd.DataFrame, estimates: pd.DataFrame
) -> None:
    submission = submission_table(estimates)
    assert len(benchmark(challenge_scores, annotation, submission)) == 11


@scoring
def test_bare_f1_by_scikit(benchmark: BenchmarkFixture, errors: pd.DataFrame) -> None:
    classes = [(errors[f"{name}_true"].to_numpy(int), errors[name].to_numpy(int)) for name in CLASSES]
    assert benchmark(lambda: [f1_score(*pair, average="weighted") for pair in classes])


@comparing
def test_comparison_of_two_runs_of_684_recordings(
    benchmark: BenchmarkFixture, annotation: pd.DataFrame, errors: pd.DataFrame
) -> None:
    second = error_table(perfect_estimates(annotation), annotation)
    compared = benchmark(lambda: compare_runs(errors, second, rng=np.random.default_rng(0)))
    assert len(compared) == 70


@comparing
def test_bare_drawing_of_the_resamples(benchmark: BenchmarkFixture, errors: pd.DataFrame) -> None:
    sizes = errors.groupby("container_id").size().tolist()

    def draw() -> int:
        rng = np.random.default_rng(0)
        return sum(rng.multinomial(n - 1, np.full(n, 1 / n), size=RESAMPLES).size for n in sizes)

    assert benchmark(draw) == RECORDINGS * RESAMPLES
