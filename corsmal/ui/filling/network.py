"""The trained filling network of the pages: of the sound of eight microphones, or of sound and sight."""

from pathlib import Path
from typing import TYPE_CHECKING

from corsmal.dataset.audio import CHANNELS
from corsmal.digests import file_fingerprint
from corsmal.errors import CorsmalError, FileError
from corsmal.ui.caching import by_key, cached
from corsmal.ui.opened import OpenedRecording
from corsmal.weights import find_weights

if TYPE_CHECKING:
    from corsmal.filling import FillingPredictor, FusedPredictor
    from corsmal.filling.config import AnyConfig

ADVICE = "train a network with `python -m corsmal train filling ROOT RUN` and set CORSMAL_FILLING_WEIGHTS to its file"

NEEDED = "this page needs one that was trained on the sound of 8 microphones, or one of sound and sight"


def network() -> "FillingPredictor | FusedPredictor":
    """The trained network.

    Raises:
        FileError: there is none, it is broken, or of arrays of sound only.
    """
    from corsmal.filling import FusedPredictor  # noqa: PLC0415 - PyTorch takes seconds to import

    found, path = any_network(), find_weights("filling").path
    if isinstance(found, FusedPredictor) or hears_log_mel(found.config):
        return found
    raise FileError(path, f"is of a network for {found.channels} × {found.config.features} features; {NEEDED}")


def any_network() -> "FillingPredictor | FusedPredictor":
    """The trained network, whatever it is given.

    Raises:
        FileError: there is none, or it is broken.
    """
    path = find_weights("filling").path
    if not path.is_file():
        raise FileError(path, f"the filling network's weights are missing; {ADVICE}")
    return _network(path, file_fingerprint(path))


def hears_log_mel(config: "AnyConfig") -> bool:
    """Whether a network is given log-mel rows of eight microphones."""
    return (config.channels, config.features) == (CHANNELS, 128)


def fused_network() -> "FusedPredictor | None":
    """The trained network, where it is of sound and sight."""
    from corsmal.filling import FusedPredictor  # noqa: PLC0415 - as above

    try:
        found = network()
    except CorsmalError:
        return None
    return found if isinstance(found, FusedPredictor) else None


@cached(2, key=lambda path, fingerprint: (path, fingerprint), spinner="Reading the filling network")
def _network(path: Path, fingerprint: str) -> "FillingPredictor | FusedPredictor":
    del fingerprint
    from corsmal.filling import open_filling  # noqa: PLC0415 - as above

    return open_filling(path)


def by_network(opened: OpenedRecording, *others: object) -> object:
    """Results that depend on the trained network, too."""
    return network().digest, by_key(opened, *others)
