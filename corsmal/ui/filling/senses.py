"""What a network of sound and sight says of a recording, with each sense's own answer, cached.

The functions raise a ``CorsmalError`` where the network or both senses are missing or cannot be read.
"""

from typing import TYPE_CHECKING

import numpy as np

from corsmal.dataset.audio import CHANNELS
from corsmal.dataset.places import file_of
from corsmal.digests import file_fingerprint
from corsmal.errors import FileError
from corsmal.filling.records import FEATURE_FOLDERS
from corsmal.ui import shared
from corsmal.ui.caching import by_key, cached
from corsmal.ui.filling.network import fused_network, network
from corsmal.ui.opened import OpenedRecording
from corsmal.weights import find_weights

if TYPE_CHECKING:
    from corsmal.filling import FusedPrediction, FusedPredictor
    from corsmal.filling.sight import FeatureFolders, Senses

Seconds = tuple[float, float]

MOMENTS = 16
"""Times of a recording until which the network is asked, equally spaced; the last one is its end."""


def folders() -> "FeatureFolders":
    """Folders of arrays that the environment names."""
    from corsmal.filling.sight import FeatureFolders  # noqa: PLC0415 - PyTorch takes seconds to import

    return FeatureFolders.in_environment()


def by_arrays(opened: OpenedRecording, *others: object) -> object:
    """Results that depend on the network and on the recording's arrays."""
    given = folders()
    arrays = [file_of(folder, opened.id, ".npy") for folder in (given.sound, given.sight) if folder is not None]
    prints = [file_fingerprint(path) for path in arrays if path.is_file()]
    return network().digest, given, prints, by_key(opened, *others)


@cached(8, key=by_arrays, spinner="Reading the features")
def given(opened: OpenedRecording) -> "Senses":
    """What the network is given of a recording."""
    from corsmal.filling.sight import recording_senses  # noqa: PLC0415 - as above

    named, sizes = folders(), _fused().config.sound[0]
    if named.sound is None and (sizes.channels, sizes.features) != (CHANNELS, 128):
        raise FileError(
            find_weights("filling").path,
            f"hears arrays of {sizes.channels} × {sizes.features} features; name their folder in {FEATURE_FOLDERS}",
        )
    return recording_senses(
        opened.recording,
        sight=named.sight,
        folder=named.sound,
        parameters=_fused().front_end,
        store=shared.store(),
    )


@cached(512, key=by_arrays)
def prediction(opened: OpenedRecording, crop_s: Seconds | None) -> "FusedPrediction":
    """The prediction for a crop, or for the whole recording."""
    from corsmal.filling.fused_prediction import predicted_within  # noqa: PLC0415 - as above

    return predicted_within(given(opened), _fused(), crop_s or (0.0, np.inf))


@cached(32, key=by_arrays, spinner="Asking the network moment by moment")
def moments(opened: OpenedRecording) -> "list[tuple[float, FusedPrediction]]":
    """What the network would have said, had the recording ended earlier."""
    from corsmal.filling.fused_prediction import predicted_until  # noqa: PLC0415 - as above

    found = given(opened)
    return predicted_until(found, _fused(), np.linspace(0, found.duration_s, MOMENTS + 1)[1:].tolist())


def _fused() -> "FusedPredictor":
    found = fused_network()
    if found is None:
        raise FileError(find_weights("filling").path, "is no network of sound and sight")
    return found
