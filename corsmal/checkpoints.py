"""What trainings by Lightning share: checkpoints that are read without code, and fewer messages."""

import contextlib
import logging
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from corsmal.errors import FileError
from corsmal.state_dicts import READING_ERRORS


def read_checkpoint(path: Path) -> dict[str, Any] | None:
    """A training's checkpoint, without pickled code; None where there is none.

    Raises:
        FileError: the file is none.
    """
    import torch  # noqa: PLC0415 - takes seconds

    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
        content["state_dict"], content["epoch"], content["global_step"], content["callbacks"]
    except FileNotFoundError:
        return None
    except READING_ERRORS as error:
        raise FileError(path, "is not a checkpoint of this training; delete it to begin again") from error
    return dict(content)


@contextlib.contextmanager
def quiet_lightning() -> Iterator[None]:
    """Suppress what Lightning reports at every start: accelerators, other products, resumed runs, its own old calls."""
    logger = logging.getLogger("lightning.pytorch")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Checkpoint directory .* exists and is not empty")
            warnings.filterwarnings("ignore", message=".*isinstance.treespec, LeafSpec")  # its own call of PyTorch
            yield
    finally:
        logger.setLevel(level)
