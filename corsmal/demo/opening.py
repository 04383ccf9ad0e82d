"""Opening the ready-made demo: its recordings and results are copied from the library into the cache.

Results are kept under the times of the files that they were computed from, and neither a clone nor a package keeps
times. So every copy gets the time at which the pack was made, and the keys are the same everywhere. A store that reads
the library's folder in place would need keys of another kind; the copy takes a fraction of a second, and its files may
be changed, deleted and added to.
"""

import json
import os
import shutil
import threading
import uuid
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from corsmal import files
from corsmal.errors import FileError
from corsmal.files import check_plain_file
from corsmal.store import BYTES_MAX, Store
from corsmal.weights import BUNDLED

if TYPE_CHECKING:
    from corsmal.runs.run import Run

PACK = Path(__file__).parent / "pack"
"""Holds ``recordings``, a dataset, and ``results``, a store."""

MARK = Path("truth", "pack.json")
"""In the dataset: says when the pack was made. A folder that has it is whole."""

FOLDER, FULL_FOLDER = "demo-six", "demo-thirty"
"""Where the ready-made demo is opened and the full one is made, beneath the store's folder."""

RUNS = "runs"
"""Of the results, what is not copied but kept anew: a run names its dataset's folder and the files of its networks."""

ADVICE = "set CORSMAL_CACHE to a folder that can be written"

writing = partial(files.writing, advice=ADVICE)

_opening = threading.Lock()


def demo_folder(store: Store) -> Path:
    """Where the ready-made demo is, or is to be."""
    return store.root.resolve() / FOLDER


def full_demo_folder(store: Store) -> Path:
    """Where the full demo is, or is to be."""
    return store.root.resolve() / FULL_FOLDER


def is_open(store: Store) -> bool:
    """Whether the store has this version's demo."""
    mark = demo_folder(store) / MARK
    try:
        check_plain_file(mark, bytes_max=BYTES_MAX)
        return mark.read_bytes() == (PACK / "recordings" / MARK).read_bytes()
    except (FileError, OSError):
        return False


def open_demo(*, store: Store | None = None) -> Path:
    """Copy the demo into the store, unless it is there; that of another version is replaced.

    Threads and processes may do so at once: the dataset's folder appears whole.

    Args:
        store: default: the one that everything else uses.

    Returns:
        The dataset's folder.

    Raises:
        FileError: the pack cannot be read, or the store cannot be written.
    """
    store = store or Store()
    if not is_open(store):
        with _opening:
            if not is_open(store):
                _copy_pack(store)
    return demo_folder(store)


def _copy_pack(store: Store) -> None:
    folder, recordings, results = demo_folder(store), PACK / "recordings", PACK / "results"
    begun = folder.with_name(f".{FOLDER}.{uuid.uuid4().hex}")
    made_ns = made_when(recordings / MARK)
    try:
        for path in _files(results):
            if path.relative_to(results).parts[0] != RUNS:
                _copy(path, store.root / path.relative_to(results), time_ns=made_ns)
        for path in _files(recordings):
            _copy(path, begun / path.relative_to(recordings), time_ns=made_ns)
        _keep_runs(results, store=store)
        _put_in_place(begun, folder, store)
    finally:
        shutil.rmtree(begun, ignore_errors=True)


def _put_in_place(begun: Path, folder: Path, store: Store) -> None:
    """Let a folder that is whole take the place of what is not this version's demo."""
    for is_last in (False, True):
        try:
            os.rename(begun, folder)
        except OSError as error:
            if is_open(store):  # another process was faster
                return
            if is_last:
                raise FileError(folder, f"cannot be written ({error.strerror}); {ADVICE}") from error
            shutil.rmtree(folder, ignore_errors=True)
        else:
            return


def set_times(folder: Path, time_ns: int) -> None:
    """Give all files of a folder one time of change."""
    for path in _files(folder):
        os.utime(path, ns=(time_ns, time_ns))


def with_networks_in(run: "Run", weights: Path) -> "Run":
    """The run with its networks' files, whose names stay, in another folder."""
    filling, mass, detector = run.settings.filling, run.settings.mass, run.settings.detector
    settings = replace(
        run.settings,
        filling=filling and replace(filling, path=weights / filling.path.name),
        mass=mass and replace(mass, path=weights / mass.path.name),
        detector=detector and replace(detector, weights=detector.weights and weights / detector.weights.name),
    )
    return replace(run, settings=settings)


def _keep_runs(results: Path, *, store: Store) -> None:
    from corsmal.runs.run import list_runs, load_run, save_run  # noqa: PLC0415 - loads much, the demo is opened once

    folder = str(demo_folder(store))
    for run in list_runs(store=Store(results)):
        earlier = load_run(run.name, dataset=folder, store=store)  # of another version's demo
        kept = replace(with_networks_in(run, BUNDLED), dataset=folder, id=run.id if earlier is None else earlier.id)
        save_run(kept, store=store)


def made_when(mark: Path) -> int:
    """When a pack was made, in ns since 1970, from its ``MARK``.

    Raises:
        FileError: the file is missing or broken.
    """
    try:
        return int(json.loads(mark.read_text(encoding="utf-8"))["made_ns"])
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise FileError(mark, "is missing or broken; restore the library's files") from error


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def _copy(source: Path, target: Path, *, time_ns: int) -> None:
    with writing(target) as part:
        shutil.copyfile(source, part)
        os.utime(part, ns=(time_ns, time_ns))
