"""In which recordings of a run a mask by hand would tell most, and where in each."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from corsmal.dataset import Dataset
from corsmal.errors import CorsmalError
from corsmal.quantities import GEOMETRY
from corsmal.runs.run import Run, list_runs
from corsmal.stages.detections import load_detections
from corsmal.stages.hand_comparison import Candidate, frames_to_correct
from corsmal.store import Store

NO_RUN = "No run of this dataset says how sure its estimates are; one of the preset `tuned` does."


@dataclass(frozen=True)
class UnsureRecording:
    """A recording whose estimate is not sure, and the frame in it whose mask is worth correcting first.

    Args:
        recording_id: the recording's id.
        width: mean width of the 90 % intervals of the four quantities, as a share of the values.
        candidate: the frame.
    """

    recording_id: str
    width: float
    candidate: Candidate

    def __str__(self) -> str:
        """For people."""
        return f"{self.recording_id}: 90 % intervals of {100 * self.width:.0f} % of the values; {self.candidate}"


def run_to_correct(dataset: Dataset, *, store: Store) -> Run | None:
    """The newest run of a dataset whose rows have 90 % intervals, as ``tuned`` gives them; None if there is none."""
    runs = list_runs(store=store, dataset=dataset.root)
    return next((run for run in runs if not run.is_archived and recordings_to_correct(run.rows)), None)


def masks_to_correct(run: Run, dataset: Dataset, *, store: Store, without: str = "") -> Iterator[UnsureRecording]:
    """The recordings of a run, the least sure first, each with the frame to correct first in it.

    A recording whose frames all have masks by hand in both views, or that is not on disk any more, is left out.

    Args:
        run: of the dataset, with 90 % intervals.
        dataset: the dataset.
        store: holds detections and masks by hand, and keeps the fits: up to two dozen for each recording.
        without: id of a recording that is left out.
    """
    shape = run.settings.shape
    matched = dataset.matched(run.settings.matching, masks="detected")
    pairs = {str(row["recording_id"]): tuple(str(row.get("pair") or "").split(" + ")) for row in run.rows}
    for name, width in recordings_to_correct(run.rows):
        if name == without or name not in dataset:
            continue
        pair = next((pair for pair in shape.pairs if pair == pairs[name]), shape.pairs[0])
        try:
            detections = load_detections(matched[name], store=store)
            found = frames_to_correct(
                matched[name], detections, pair=pair, shape=shape, selection=run.settings.selection, store=store
            )
        except CorsmalError:
            continue
        if found:
            yield UnsureRecording(name, width, found[0])


def recordings_to_correct(rows: Iterable[Mapping[str, Any]]) -> list[tuple[str, float]]:
    """Recordings by how unsure their estimates are, the least sure first.

    Args:
        rows: of a run, with 90 % intervals as ``tuned`` gives them.

    Returns:
        Ids, each with the mean width of its intervals as a share of the values.
    """
    found = []
    for row in rows:
        widths = [
            (row[f"{name}_high"] - row[f"{name}_low"]) / row[name]
            for name in GEOMETRY
            if row.get(name) and row.get(f"{name}_low") is not None and row.get(f"{name}_high") is not None
        ]
        if widths:
            found.append((str(row["recording_id"]), float(np.mean(widths))))
    return sorted(found, key=lambda each: -each[1])
