"""What all sessions of one server share: the store, the background jobs, the open datasets."""

import os
from functools import cache

from corsmal.dataset import Dataset, open_dataset
from corsmal.engines.inspector import ProcessInspector
from corsmal.stages.settings import DetectorSettings
from corsmal.store import Store
from corsmal.ui.caching import cached
from corsmal.ui.jobs import Jobs


@cache
def store() -> Store:
    """The store of this server."""
    return Store()


@cache
def jobs() -> Jobs:
    """The background jobs of this server."""
    return Jobs()


@cache
def inspector(settings: DetectorSettings) -> ProcessInspector:
    """A detector in processes of its own, for all recordings that somebody waits for."""
    return ProcessInspector(settings)


@cached(8, key=lambda root: (root, _folder_times(os.path.expanduser(root))), spinner="Reading the dataset folder")
def dataset(root: str) -> Dataset:
    """The dataset in a folder, read again when a file was added to it or removed.

    Raises:
        FileError: there is no dataset.
    """
    return open_dataset(root)


def _folder_times(root: str) -> tuple[tuple[str, int], ...]:
    """Modification times of the folder and two levels below it, and of the annotation, which cost little to read."""
    times: list[tuple[str, int]] = []
    pending = [(root, 0)]
    while pending:
        folder, depth = pending.pop()
        try:
            times.append((folder, os.stat(folder).st_mtime_ns))
            with os.scandir(folder) as entries:
                for entry in entries if depth < 2 else ():
                    if entry.is_dir():
                        pending.append((entry.path, depth + 1))
                    elif depth == 0:
                        times.append((entry.path, entry.stat().st_mtime_ns))
        except (OSError, ValueError):  # the latter for what can be no file name; opening the dataset says what is wrong
            continue
    return tuple(sorted(times))
