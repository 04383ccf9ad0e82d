"""What a visitor has chosen: the recording, how it is estimated, and what each page shows of it."""

from dataclasses import dataclass, field
from typing import Any

from corsmal.dataset.clock import Match, Matching
from corsmal.dataset.layout import Masks
from corsmal.parameters import (
    SELECTION_PRESETS,
    SHAPE_PRESETS,
    Pair,
    SelectionParameters,
    ShapeParameters,
    own_selection,
)
from corsmal.ui.controls import PARAMETERS

ESTIMATE, SHOWN = "tuned", "shown"
"""The estimate over the whole recording: the preset unless another is chosen, and what says that it has ``shape``."""

NOTHING = "nothing"
"""What ``Choice.compared`` is where no second hull is drawn."""

View = tuple[float, float, float, float, float, float]
"""A view of the hull in 3D: where the eye is and what it looks at, x, y and z of each in Plotly's units."""


@dataclass(frozen=True)
class Choice:
    """What the user has chosen.

    Args:
        selection: preset of the rules for the best frame; None: that of the estimate's preset.
        dataset: name and fingerprint of the dataset, see ``permalinks.reference``; None: any that has the recording.
        recording: id; None: the first one.
        pair: views of the fit; None: the pair that the estimate used.
        frame: frame index; None: the best frame.
        shape: parameters of the fit.
        match: how frames of the views are matched; None: by time.
        masks: which masks are used, see ``dataset.layout.Masks``; None: the detected ones.
        edited: view whose masks are corrected by hand on *Frames*; None: none are.
        offsets_s: by view, how much later it was filmed than its file says, see ``Matching``.
        crop_s: start and end of the filling network's input, in hundredths of a second; None: the whole.
        channel: microphone that is drawn and played, from 0; None: the mean of all.
        estimate: preset of the estimate over the whole recording, or ``SHOWN``; None: ``tuned``, which gives intervals.
        compared: preset whose hull is drawn over the fitted one, or ``NOTHING``; None: ``tuned``, over it the paper's.
        scope: what the hull's picture frames, ``container`` or ``cameras``; None: the container.
        shows_errors: whether the hull is coloured by its errors.
        has_axes: whether the hull's picture has axes.
        camera: from where the hull is seen; None: as it is at first.
        axis: rule for the axis of a restored mask; None: the network's.
        padding_px: around a restored mask's box; None: the network's.
        numbers: what is typed over the fit's numbers for the mass, by name; None: emptied.
        container: names of the containers whose recordings are listed; empty: all. ``filling``, ``level`` and
            ``scenario`` likewise.
        lacks: which recordings are listed by what is on disk, a key of ``recordings.LACKS``.
        view: what the Evaluation page shows, a run's results, all runs or reproductions; None: results.
        run: short id of the run that is evaluated, in older addresses its name; None: the newest.
        section: of the Evaluation page; None: the first. What follows is chosen in its sections:
        protocol: which numbers of networks count.
        without: flags whose rows are left out.
        metric: whose errors are shown.
        classes: whose confusions are shown.
        beside: what stands beside the numbers of Table 2.
        against: the run that is compared with.
        within_percent: the error up to which a quantity is right.
        sure_percent: the probability below which a filling is not answered.
        rows: containers whose recordings are listed.
        only_failed: whether only failed recordings are listed.
        collection: of pins; None: none is begun yet.
    """

    recording: str | None = None
    pair: Pair | None = None
    frame: int | None = None
    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    match: Match | None = None
    offsets_s: tuple[tuple[str, float], ...] = ()
    masks: Masks | None = None
    edited: str | None = None
    crop_s: tuple[float, float] | None = None
    channel: int | None = None
    estimate: str | None = None
    selection: str | None = None
    dataset: str | None = None
    compared: str | None = None
    scope: str | None = None
    shows_errors: bool = False
    has_axes: bool = False
    camera: View | None = None
    axis: str | None = None
    padding_px: int | None = None
    numbers: tuple[tuple[str, float | None], ...] = ()
    container: tuple[str, ...] = ()
    filling: tuple[str, ...] = ()
    level: tuple[str, ...] = ()
    scenario: tuple[str, ...] = ()
    lacks: str = "video"
    view: str | None = None
    run: str | None = None
    section: str | None = None
    protocol: str | None = None
    without: tuple[str, ...] = ()
    metric: str | None = None
    classes: str | None = None
    beside: str | None = None
    against: str | None = None
    within_percent: float | None = None
    sure_percent: float | None = None
    rows: tuple[str, ...] = ()
    only_failed: bool = False
    collection: str | None = None

    @property
    def matching(self) -> Matching:
        """How the frames of the recording's views are matched; offsets are of no use where their numbers count."""
        return Matching(self.match or "time", () if self.match == "index" else self.offsets_s)

    @property
    def preset(self) -> str:
        """The preset that the parameters are nearest to: of the same method the one with the fewest differences."""
        alike = [name for name, preset in SHAPE_PRESETS.items() if preset.method == self.shape.method]
        return min(alike, key=lambda name: len(differences(self.shape, SHAPE_PRESETS[name])))

    @property
    def shape_name(self) -> str:
        """The parameters of the fit, for people."""
        return self.preset if self.is_preset else f"{self.preset}, own values"

    @property
    def estimate_name(self) -> str:
        """The parameters of the estimate over the whole recording, for people."""
        return self.shape_name if self.estimate == SHOWN else self.estimate or ESTIMATE

    @property
    def estimate_preset(self) -> str:
        """The preset that the parameters of the estimate over the whole recording are, or are nearest to."""
        return self.preset if self.estimate == SHOWN else self.estimate or ESTIMATE

    @property
    def estimated_shape(self) -> ShapeParameters:
        """The parameters of the estimate over the whole recording."""
        return self.shape if self.estimate == SHOWN else SHAPE_PRESETS[self.estimate or ESTIMATE]

    @property
    def selection_name(self) -> str:
        """The preset of the rules for the best frame."""
        return self.selection or own_selection(self.estimate_preset)

    @property
    def selected_by(self) -> SelectionParameters:
        """The rules for the best frame."""
        return SELECTION_PRESETS[self.selection_name]

    @property
    def is_preset(self) -> bool:
        """Whether the parameters are exactly a preset's."""
        return self.shape == SHAPE_PRESETS[self.preset]


OF_FIT = ("recording", "frame", "pair", "estimate", "selection", "shape", "match", "offsets_s", "masks")
"""What a fit depends on: with another one ``numbers`` are those of a fit that is not shown any more."""

OF_RECORDING: dict[str, Any] = {
    "frame": None, "pair": None, "crop_s": None, "camera": None, "numbers": (), "match": None, "offsets_s": (),
}  # fmt: skip
"""What does not outlast another recording."""

OF_DATASET: dict[str, Any] = OF_RECORDING | {
    "container": (), "filling": (), "level": (), "scenario": (), "lacks": "video",
    "run": None, "against": None, "rows": (),
}  # fmt: skip
"""What does not outlast another dataset."""


def differences(shape: ShapeParameters, preset: ShapeParameters) -> dict[str, Any]:
    """The parameters of a fit, by field, that are not a preset's."""
    return {name: getattr(shape, name) for name in PARAMETERS if getattr(shape, name) != getattr(preset, name)}


def estimate_of(shape: ShapeParameters) -> str | None:
    """What ``Choice.estimate`` is where the shown parameters are also those of the estimate."""
    name = next((name for name, preset in SHAPE_PRESETS.items() if preset == shape), SHOWN)
    return None if name == ESTIMATE else name
