"""The means of a training set, which stand in for what could not be fitted (paper 3.1)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from corsmal.dataset import Annotation, Dataset
from corsmal.errors import ArgumentError
from corsmal.quantities import GEOMETRY, MEASURED


@dataclass(frozen=True)
class ContainerMean:
    """One container of a training set.

    Args:
        container_id: its number.
        recordings: how many recordings of it are annotated.
        means: over them, of each of ``MEASURED``, in that order; None where it is not annotated.
    """

    container_id: int
    recordings: int
    means: tuple[float | None, ...]


@dataclass(frozen=True)
class TrainingMeans:
    """The means of an annotated training set, by container, so that no container is judged by itself.

    Args:
        source: name of the training set, for people.
        containers: its containers.
    """

    source: str
    containers: tuple[ContainerMean, ...]

    @classmethod
    def of(cls, dataset: Dataset) -> "TrainingMeans":
        """The means of a dataset.

        Args:
            dataset: its annotation must have the capacity, the widths and the height of some recording.

        Raises:
            ArgumentError: the annotation lacks them; a fallback without a truth behind it would be no mean.
        """
        table = dataset.table[["container_id", *MEASURED]].dropna(subset=["container_id", *GEOMETRY])
        if table.empty:
            raise ArgumentError(
                f"the means of {dataset.name} are not known: its annotation has no recording with capacity, widths, "
                "height and container; name the folder of the training set"
            )
        groups = table.groupby("container_id")
        return cls(dataset.name, tuple(_container(int(str(number)), group) for number, group in groups))

    def for_container(self, known: Annotation | None) -> dict[str, float]:
        """What stands in for a recording that could not be fitted.

        Args:
            known: the recording's annotation, where there is one. A container of the training set is recognised by its
                number and its capacity, and left out: its recordings fall back to the means of the other containers.

        Returns:
            Quantity to mean over the recordings; empty where no other container is left.
        """
        others = [container for container in self.containers if not _is_same(container, known)]
        means = {}
        for place, name in enumerate(MEASURED):
            parts = [(each.recordings, value) for each in others if (value := each.means[place]) is not None]
            if parts:
                means[name] = sum(count * value for count, value in parts) / sum(count for count, _ in parts)
        return means

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "TrainingMeans":
        """The means from what ``dataclasses.asdict`` made of them.

        Raises:
            ArgumentError: it is something else.
        """
        try:
            containers = [
                ContainerMean(int(each["container_id"]), int(each["recordings"]), _numbers(each["means"]))
                for each in content["containers"]
            ]
            return cls(str(content["source"]), tuple(containers))
        except (LookupError, TypeError, ValueError) as error:
            raise ArgumentError(f"content must be the means of a training set, got {str(content)[:60]}") from error


def _container(number: int, group: pd.DataFrame) -> ContainerMean:
    means = (group[name].mean() for name in MEASURED)
    return ContainerMean(number, len(group), tuple(None if pd.isna(mean) else float(mean) for mean in means))


def _is_same(container: ContainerMean, known: Annotation | None) -> bool:
    return (
        known is not None and known.container_id == container.container_id and known.capacity_ml == container.means[0]
    )


def _numbers(values: Any) -> tuple[float | None, ...]:
    if len(values) != len(MEASURED):
        raise ValueError(f"{len(values)} values")
    return tuple(None if value is None else float(value) for value in values)
