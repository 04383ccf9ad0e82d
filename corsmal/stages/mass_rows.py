"""What the mass network is trained on and judged by, from a dataset whose containers were detected."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from corsmal.dataset import Recording
from corsmal.errors import NotFoundError
from corsmal.estimation import RecordingMasks, estimate, mass_inputs
from corsmal.mass import MassRow
from corsmal.parameters import ShapeParameters, selection_of
from corsmal.quantities import DIMENSIONS
from corsmal.stages.detections import load_detections
from corsmal.store import Store

NOTHING = {"mask": np.zeros((1, 1), dtype=bool), "mm_per_px": None} | dict.fromkeys(DIMENSIONS)
"""What is known of a container that could not be fitted."""


def mass_rows(
    recordings: Sequence[Recording],
    *,
    store: Store,
    shape: ShapeParameters | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Iterator[MassRow]:
    """A row for every recording whose container's mass is annotated: its mask in the best frame and its measures.

    The selection is that of the shape's preset. Detections are beside the videos or in the store; ``progress`` is
    called with the numbers of recordings done and wanted. Where nothing could be fitted, or the frontal view shows no
    container, the row has an empty mask and no measures.
    """
    shape = shape or ShapeParameters.paper()
    selection = selection_of(shape)
    for index, recording in enumerate(recordings):
        known = recording.annotation
        if known is not None and known.container_mass_g:
            detections = load_detections(recording, store=store).views
            found = estimate(recording, detections=detections, shape=shape, selection=selection)
            masks = RecordingMasks(recording, detections, selection)
            try:
                inputs = mass_inputs(found, masks) or NOTHING
            except NotFoundError:  # no container in the frontal view
                inputs = NOTHING
            yield MassRow(recording.id, known.container or "unknown", mass_g=known.container_mass_g, **inputs)
        if progress is not None:
            progress(index + 1, len(recordings))
