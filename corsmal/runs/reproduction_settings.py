"""Settings of a reproduction, and the plan of its steps with the time that each takes."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from corsmal.dataset import Dataset, Recording
from corsmal.dataset.audio import CHANNELS, sound_duration_s
from corsmal.dataset.clock import Matching
from corsmal.errors import ArgumentError, FileError
from corsmal.estimation import TrainingMeans
from corsmal.parameters import METHOD_VIEWS, FillingPreset, NetworkPreset, ShapeParameters, selection_of
from corsmal.stages.settings import DetectorSettings, EstimateSettings

if TYPE_CHECKING:
    from corsmal.filling import FillingTraining, FusedTraining
    from corsmal.mass import MassTraining

Protocol = Literal["held-out", "paper"]
Folds = Literal["spread", "containers"]

QUICK_EPOCHS, QUICK_MASS_EPOCHS = 3, 20
FILLING_FOLDS, MASS_FOLDS, CONTAINER_FOLDS = 7, 5, 3


@dataclass(frozen=True)
class ReproductionSettings:
    """How the paper's evaluation is repeated.

    Args:
        protocol: ``held-out``: every number comes from a network that has not seen the recording, and whose epoch was
            chosen by other recordings; ``paper``: filling is judged on the fold by which its epoch was chosen, mass on
            the fifth of the recordings by which its training was stopped.
        folds: ``spread``: seven folds for the filling with every configuration in each, five for the mass with every
            container in each; ``containers``: three folds of containers that the network has not seen.
        seeds: number of cross-validations, with the seeds 0, 1, ….
        shape: parameters of the fit.
        networks: preset of both networks and of the filling's training; with ``fused`` the mass network is as tuned.
        features: folder of arrays of the sound for the filling network; None: log-mel of the sound.
        sight: folder of arrays of the videos, for ``fused``.
        detector: for recordings without detections; None: they have no geometry.
        is_quick: few epochs, for a first look; the tables say so.
        matching: how the frames of the recordings' views are matched.

    Raises:
        ArgumentError: a choice is unknown, seeds is below 1, or there is sight without ``fused`` or the reverse.
    """

    protocol: Protocol = "held-out"
    folds: Folds = "spread"
    seeds: int = 1
    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    networks: FillingPreset = "paper"
    features: Path | None = None
    sight: Path | None = None
    detector: DetectorSettings | None = None
    is_quick: bool = False
    matching: Matching = field(default_factory=Matching)

    def __post_init__(self) -> None:
        for name, choices in (("protocol", Protocol), ("folds", Folds), ("networks", FillingPreset)):
            if getattr(self, name) not in get_args(choices):
                raise ArgumentError(f"{name} must be one of {get_args(choices)}, got {getattr(self, name)!r}")
        if self.seeds < 1:
            raise ArgumentError(f"seeds must be at least 1, got {self.seeds}")
        if (self.networks == "fused") != (self.sight is not None):
            found = f"the networks {self.networks!r} and {self.sight or 'none'}"
            raise ArgumentError(f"features of the videos belong to the networks 'fused', and to them only, got {found}")

    def estimates_with(self, means: TrainingMeans | None) -> EstimateSettings:
        """What recordings are estimated with, but for the networks."""
        return EstimateSettings(
            self.shape, means, detector=self.detector, matching=self.matching, selection=selection_of(self.shape)
        )

    @property
    def filling(self) -> "FillingTraining | FusedTraining":
        """How the filling networks are trained."""
        from corsmal.filling import FillingTraining, FusedTraining  # noqa: PLC0415 - loads PyTorch

        if self.networks == "fused":
            return FusedTraining().lasting(QUICK_EPOCHS) if self.is_quick else FusedTraining()
        training = FillingTraining.of(self.networks)
        return replace(training, epochs=QUICK_EPOCHS) if self.is_quick else training

    @property
    def mass(self) -> "MassTraining":
        """How the mass networks are trained."""
        from corsmal.mass import MassConfig, MassTraining  # noqa: PLC0415 - as above

        network = MassConfig.of(NETWORKS[self.networks][2])
        training = MassTraining(network=network)
        return replace(training, epochs=QUICK_MASS_EPOCHS) if self.is_quick else training

    def sentence(self) -> str:
        """How the numbers were made, for a report."""
        judged = {
            "held-out": "Held-out protocol: no network was trained on a recording that it is judged on, nor was its "
            "epoch chosen on it",
            "paper": "The paper's protocol: filling is judged on the fold by which its epoch was chosen, container "
            "mass on the fifth of the recordings by which its training was stopped",
        }[self.protocol]
        split = {
            "spread": "recordings are spread over the folds, so that the containers are known to the networks",
            "containers": "folds are whole containers (1, 4, 7; 2, 5, 8; 3, 6, 9), unknown to the networks",
        }[self.folds]
        quick = " Trained for a few epochs only (quick): a first look, not a result." if self.is_quick else ""
        return f"{judged}; {split}.{quick}"


@dataclass(frozen=True)
class PlannedStep:
    """A step of the plan.

    Args:
        name: of the step.
        what: what it does, for people.
        seconds: how long it should take on two cores, where nothing of it is kept yet.
    """

    name: str
    what: str
    seconds: float


DETECT_S = {"demo": 0.09, "coco": 2.5}
"""A frame of the small network, and of Mask R-CNN, as which detectors of other packages are counted."""

FRAMES_SEARCHED = 45
"""Frames of a view that a search for the best frame inspects in a recording of ten seconds."""

FIT_S = {"circumferences": 0.05, "outlines": 0.7}
MEL_S, ARRAY_EPOCH_S = 0.3, 0.0025
"""Of a recording: log-mel of ten seconds with eight channels; an epoch on an array."""

MEL_EPOCH_S = (2.0e-3, 1.7e-4)
"""An epoch on the log-mel of eight channels: per second of sound, and per square second, for the attention."""

NETWORKS: dict[FillingPreset, tuple[int, int, NetworkPreset]] = {
    "paper": (1, 150, "paper"),
    "released": (1, 100, "released"),
    "tuned": (8, 30, "tuned"),
    "fused": (7, 30, "tuned"),
}
"""How many filling networks a preset averages, their epochs, and the preset of the mass network. Of ``fused`` as many
count as take as long as its networks of both senses and those that its gate is learned from."""

RELEASED_EPOCH = {"sound": 1.45, "arrays": 5.0}
"""How many times as long as the paper's an epoch of ``released`` takes, with one recording at a time, on log-mel and on
arrays."""

MASS_EPOCHS, MASS_EPOCH_S = 150, 0.004
"""Epochs that a training of the mass network lasts, and seconds of one for a recording."""


def plan(dataset: Dataset, settings: ReproductionSettings, tests: Sequence[Dataset] = ()) -> list[PlannedStep]:
    """The steps of a reproduction with the time that each takes, as measured on two cores.

    Args:
        dataset: the training set.
        settings: the settings.
        tests: test sets.
    """
    filmed = [recording for recording in dataset if is_filmed(recording)]
    table = dataset.table
    known = table.index[table["filling_type"].notna()]
    labelled = len(known)
    weighed = sum(1 for recording in filmed if recording.annotation and recording.annotation.container_mass_g)
    by_container = settings.folds == "containers"
    if settings.features is None:
        epoch_s = sum(_mel_epoch_s(dataset[name]) for name in known)
    else:
        epoch_s = labelled * ARRAY_EPOCH_S
    if settings.networks == "released":
        epoch_s *= RELEASED_EPOCH["sound" if settings.features is None else "arrays"]
    count, epochs, _ = NETWORKS[settings.networks]
    epochs = QUICK_EPOCHS if settings.is_quick else epochs
    filling_s = count * epochs * epoch_s
    rounds = settings.seeds * (CONTAINER_FOLDS if by_container else FILLING_FOLDS)
    mass_epochs = QUICK_MASS_EPOCHS if settings.is_quick else MASS_EPOCHS
    mass_folds = CONTAINER_FOLDS if by_container else MASS_FOLDS
    mass_rounds = settings.seeds * (mass_folds if settings.protocol == "held-out" else 1)
    mass_round_s = mass_epochs * weighed * MASS_EPOCH_S
    steps = [
        PlannedStep("geometry", f"best frames and hulls of {len(filmed)} recordings", _geometry_s(filmed, settings)),
        PlannedStep(
            "features",
            f"what the filling network is given of {labelled} recordings, {CHANNELS} channels"
            if settings.features is None
            else f"arrays of {labelled} recordings",
            labelled * (MEL_S if settings.features is None else 0.001),
        ),
        PlannedStep("filling", f"{rounds * count} networks of {epochs} epochs", rounds * filling_s),
        PlannedStep("masks", f"masks and dimensions of {weighed} recordings", weighed * FIT_S[settings.shape.method]),
        PlannedStep("mass", f"{mass_rounds} networks", mass_rounds * mass_round_s),
        PlannedStep("final networks", "one of each kind on all recordings", filling_s + mass_round_s),
    ]
    for name, test in named_tests(tests).items():
        recordings = [recording for recording in test if is_filmed(recording)]
        steps.append(PlannedStep(f"test {name}", f"{len(test)} recordings", _geometry_s(recordings, settings)))
    return [*steps, PlannedStep("tables", "tables, figures, submissions and the report", 20.0)]


def named_tests(tests: Sequence[Dataset]) -> dict[str, Dataset]:
    """The test sets by name: their folders', with a number where folders are named alike.

    Raises:
        ArgumentError: a folder is named twice.
    """
    alike, names = Counter(test.name for test in tests), dict[str, Dataset]()
    for test in tests:
        if any(test.root.resolve() == other.root.resolve() for other in names.values()):
            raise ArgumentError(f"the test set {test.root} is named more than once")
        place = sum(other.name == test.name for other in names.values()) + 1
        names[test.name if alike[test.name] == 1 else f"{test.name}-{place}"] = test
    return names


def check_features(*folders: Path | None) -> None:
    """Refuse a folder of features that is not there.

    Raises:
        FileError: it is not.
    """
    for folder in folders:
        if folder is not None and not folder.is_dir():
            raise FileError(folder, "there is no such folder of features")


def features_text(settings: ReproductionSettings, *, by: Callable[[Path], str] = str) -> str:
    """What the filling network is given, for people; ``by`` names a folder."""
    heard = "log-mel of the sound" if settings.features is None else by(settings.features)
    return heard if settings.sight is None else f"{heard}; {by(settings.sight)}"


def is_filmed(recording: Recording) -> bool:
    """Whether there is anything of a recording that a hull could be fitted to."""
    return any(name in recording.views for name in METHOD_VIEWS)


def _mel_epoch_s(recording: Recording) -> float:
    """An epoch on a recording's log-mel: rows are encoded one by one, and each attends to all."""
    if recording.audio_path is None:
        return 0.0
    try:
        duration_s = sound_duration_s(recording.audio_path)
    except FileError:
        return 0.0
    linear, square = MEL_EPOCH_S
    return linear * duration_s + square * duration_s**2


def _geometry_s(recordings: Iterable[Recording], settings: ReproductionSettings) -> float:
    frame_s = 0.0 if settings.detector is None else DETECT_S.get(settings.detector.method, DETECT_S["coco"])
    views = [recording.views[name] for recording in recordings for name in METHOD_VIEWS if name in recording.views]
    without = sum(view.detections_path is None for view in views)
    return len(views) / len(METHOD_VIEWS) * FIT_S[settings.shape.method] + without * FRAMES_SEARCHED * frame_s
