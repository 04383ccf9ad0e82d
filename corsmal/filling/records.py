"""What the network says about one recording. A prediction that failed is a record with a reason, never NaN."""

from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.annotation import FILLINGS, LEVELS, Kind
from corsmal.errors import ArgumentError, check_choice

TYPE_NAMES = FILLINGS
"""Names of the filling types 0 to 3, in the order of the type logits."""

LEVEL_NAMES = LEVELS
"""Names of the filling levels 0 to 2, in the order of the level logits."""

KINDS: tuple[Kind, ...] = get_args(Kind)
"""Kinds of containers, in the order in which sight tells them apart."""

NAMES = {"filling_type": TYPE_NAMES, "filling_level": LEVEL_NAMES}
"""The classes' names by the annotation's column."""

PREDICTION_COLUMNS = (
    "recording_id",
    "container_id",
    "fold",
    "seed",
    "true_type",
    "true_level",
    "predicted_type",
    "predicted_level",
)
"""Of a cross-validation, a row per recording and seed: what the network that was not trained on its fold predicts."""

FEASIBLE_PAIRS = ((0, 0), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
"""The (type, level) pairs that exist: nothing is empty, and a filling is half or full."""

FEATURE_FOLDERS = "CORSMAL_FEATURES"
"""The environment's variable with folders of arrays for the filling network, separated as in ``PATH``."""

Decoding = Literal["independent", "feasible"]
"""How classes are read off the probabilities: each head's most probable one (the paper), or the feasible pair whose
product of probabilities is the largest, the first of equals."""

SUM_TOLERANCE = 1e-3


@dataclass(frozen=True, eq=False)
class FillingPrediction:
    """Filling type and level of one recording. Arrays are None when the prediction failed.

    Args:
        type_logits: (4,) before the softmax; of several networks: logarithms of their mean probabilities.
        level_logits: (3,), likewise.
        attention: (T,) how much the cls embedding attends to each row of the features in the last encoder block, mean
            over its heads; sums to 1. None if it is not known.
        steps_s: seconds from one row of the features to the next; None if it is not known.
        rows: [start, end) of the features' rows that the networks saw; None if it is not known.
        decoding: how type and level are read off the probabilities.
        reason: why there is no prediction; empty if there is one.

    Raises:
        ArgumentError: an array has another shape, is not finite, or the attention does not sum to 1.
    """

    type_logits: NDArray[np.float64] | None
    level_logits: NDArray[np.float64] | None
    attention: NDArray[np.float64] | None = None
    steps_s: float | None = None
    rows: tuple[int, int] | None = None
    decoding: Decoding = "independent"
    reason: str = ""

    def __post_init__(self) -> None:
        check_choice("decoding", self.decoding, get_args(Decoding))
        if self.steps_s is not None and not 0 < self.steps_s < np.inf:
            raise ArgumentError(f"steps_s must be positive, got {self.steps_s}")
        for name, classes in (("type_logits", len(TYPE_NAMES)), ("level_logits", len(LEVEL_NAMES))):
            logits = getattr(self, name)
            if (logits is None) != bool(self.reason):
                raise ArgumentError(f"{name} must be given, or else a reason why there are none")
            if logits is not None and not (logits.shape == (classes,) and np.isfinite(logits).all()):
                raise ArgumentError(f"{name} must be ({classes},) finite numbers, got {logits}")
        self._check_attention()

    def _check_attention(self) -> None:
        if self.attention is None:
            return
        if self.attention.ndim != 1 or not (self.attention >= 0).all():
            raise ArgumentError(f"attention must be (T,) numbers from 0 on, got shape {self.attention.shape}")
        if abs(self.attention.sum() - 1) > SUM_TOLERANCE:
            raise ArgumentError(f"attention must sum to 1, got {self.attention.sum()}")
        if self.rows is not None and len(self.attention) != self.rows[1] - self.rows[0]:
            raise ArgumentError(f"attention must have one value per row of {self.rows}, got {len(self.attention)}")

    @property
    def ok(self) -> bool:
        """Whether there is a prediction."""
        return not self.reason

    @property
    def type_probabilities(self) -> NDArray[np.float64] | None:
        """(4,) probabilities of none, pasta, rice and water; None when the prediction failed."""
        return None if self.type_logits is None else _softmax(self.type_logits)

    @property
    def level_probabilities(self) -> NDArray[np.float64] | None:
        """(3,) probabilities of empty, half and full; None when the prediction failed."""
        return None if self.level_logits is None else _softmax(self.level_logits)

    @property
    def probabilities(self) -> dict[str, float]:
        """Of every type and level, by name; empty when the prediction failed."""
        types, levels = self.type_probabilities, self.level_probabilities
        if types is None or levels is None:
            return {}
        return dict(zip((*TYPE_NAMES, *LEVEL_NAMES), (*types.tolist(), *levels.tolist()), strict=True))

    @property
    def pair(self) -> tuple[int, int] | None:
        """(type, level), as ``decoding`` reads them; None when the prediction failed."""
        types, levels = self.type_probabilities, self.level_probabilities
        return None if types is None or levels is None else decode(types, levels, decoding=self.decoding)

    @property
    def filling_type(self) -> int | None:
        """0 to 3: none, pasta, rice, water; None when the prediction failed."""
        return None if self.pair is None else self.pair[0]

    @property
    def filling_level(self) -> int | None:
        """0 to 2: empty, half, full; None when the prediction failed."""
        return None if self.pair is None else self.pair[1]

    @classmethod
    def failed(cls, reason: str) -> "FillingPrediction":
        """No prediction, with the reason."""
        return cls(None, None, reason=reason)


@dataclass(frozen=True, eq=False)
class FusedPrediction(FillingPrediction):
    """A prediction from both senses, with what each of them says.

    Args:
        sound: what only sound says; None: it is missing.
        sight: what only sight says; None: it is missing.
        sight_share: of sight in the level, 0..1; 0 or 1 where a sense is missing.
        kind_probabilities: (3,) of the container's ``KINDS``, as sight recognises it; None: sight is missing.
    """

    sound: FillingPrediction | None = None
    sight: FillingPrediction | None = None
    sight_share: float = 0.0
    kind_probabilities: NDArray[np.float64] | None = None


class PredictsFilling(Protocol):
    """What tells a recording's filling from features of its sound, such as ``FillingPredictor``.

    The features are log-mel rows of the paper's front end, or of the one that an attribute ``front_end`` holds.
    """

    def predict(self, features: NDArray[np.floating], *, steps_s: float | None = None) -> FillingPrediction:
        """What one recording holds.

        Args:
            features: (C, T, columns), log-mel of the sound unless ``estimate`` was given other features.
            steps_s: seconds from one row to the next.
        """


def decode(
    type_probabilities: NDArray[np.float64], level_probabilities: NDArray[np.float64], *, decoding: Decoding
) -> tuple[int, int]:
    """The (type, level) that two heads' probabilities, (4,) and (3,), stand for, see ``Decoding``."""
    if decoding == "independent":
        return int(np.argmax(type_probabilities)), int(np.argmax(level_probabilities))
    products = [type_probabilities[filling] * level_probabilities[level] for filling, level in FEASIBLE_PAIRS]
    return FEASIBLE_PAIRS[int(np.argmax(products))]


def _softmax(logits: NDArray[np.float64]) -> NDArray[np.float64]:
    powers = np.exp(logits - logits.max())
    return powers / powers.sum()
