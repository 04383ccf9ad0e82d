"""A dataset's recordings with what the filling network listens to."""

from pathlib import Path

from corsmal.commands import complain, progress_bar
from corsmal.dataset import open_dataset
from corsmal.errors import CorsmalError, FileError
from corsmal.filling import FillingSample, filling_samples
from corsmal.filling.features import recording_features
from corsmal.store import Store


def dataset_samples(root: Path, features: Path | None) -> list[FillingSample]:
    """The annotated recordings of a dataset with their features; recordings whose sound is broken are named.

    Raises:
        FileError: there is no recording with both.
    """
    dataset, store = open_dataset(root), Store()
    found = {}
    with progress_bar("features") as progress:
        for index, name in enumerate(dataset.table.index):
            try:
                found[name] = recording_features(dataset[name], folder=features, store=store).values
            except CorsmalError as error:
                complain(name, error)
            progress(index + 1, len(dataset))
    samples = filling_samples(dataset.table, found)
    if not samples:
        raise FileError(root, "has no recording with both a sound and an annotated filling")
    return samples
