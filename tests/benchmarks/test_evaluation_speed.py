import numpy as np
import pandas as pd
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.evaluation import (
    challenge_scores,
    compare_runs,
    confusion_tables,
    container_table,
    error_table,
    submission_table,
)
from tests.evaluation.made import made_annotation, perfect_estimates

RECORDINGS = 684


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


def test_all_tables_of_684_recordings(
    benchmark: BenchmarkFixture, annotation: pd.DataFrame, estimates: pd.DataFrame
) -> None:
    def tables() -> list[pd.DataFrame]:
        errors = error_table(estimates, annotation)
        confusions = [
            table for name in ("filling_type", "filling_level") for table in confusion_tables(errors, name).values()
        ]
        return [container_table(errors), *confusions]

    assert len(benchmark(tables)) == 7


def test_challenge_scores_of_684_recordings(
    benchmark: BenchmarkFixture, annotation: pd.DataFrame, estimates: pd.DataFrame
) -> None:
    submission = submission_table(estimates)
    assert len(benchmark(challenge_scores, annotation, submission)) == 11


def test_comparison_of_two_runs_of_684_recordings(
    benchmark: BenchmarkFixture, annotation: pd.DataFrame, estimates: pd.DataFrame
) -> None:
    first, second = error_table(estimates, annotation), error_table(perfect_estimates(annotation), annotation)
    compared = benchmark(lambda: compare_runs(first, second, rng=np.random.default_rng(0)))
    assert len(compared) == 70
