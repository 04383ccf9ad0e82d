"""Networks in files: weights as safetensors with their config beside them, and the checkpoints of a training."""

import contextlib
import json
import logging
import pickle
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import safetensors
import safetensors.torch
import torch
from torch import Tensor, nn

from corsmal.errors import FileError
from corsmal.files import writing


def save_network(path: Path, network: nn.Module, *, kind: str, config: Mapping[str, Any], half: bool = False) -> None:
    """Write a network's weights and its config into one file.

    Args:
        path: the file, ``.safetensors``.
        network: whose state is written.
        kind: which network it is; ``read_network`` asks for it.
        config: its sizes, anything that JSON can hold.
        half: write the parameters in half precision. Buffers, such as the statistics of inputs, keep theirs.

    Raises:
        FileError: the file cannot be written.
    """
    parameters = dict(network.named_parameters())
    state = {
        name: (value.half() if half and name in parameters else value).detach().cpu().contiguous()
        for name, value in network.state_dict().items()
    }
    with writing(path, advice="choose another folder", errors=(safetensors.SafetensorError,)) as part:
        safetensors.torch.save_file(state, part, {"kind": kind, "config": json.dumps(config)})


def read_network(path: Path, *, kind: str, advice: str) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """The config and the state, in single precision, of a file that ``save_network`` wrote.

    Args:
        path: the file.
        kind: which network it must be of.
        advice: what the user can do when it is another or broken.

    Raises:
        FileError: the file is absent, broken, of another network, or holds weights that are not finite.
    """
    try:
        with safetensors.safe_open(path, "pt") as file:
            metadata = file.metadata() or {}
            state = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
        config = json.loads(metadata["config"])
        found = metadata["kind"]
    except (OSError, safetensors.SafetensorError, KeyError, ValueError) as error:
        raise FileError(path, f"is no file of the {kind} network's weights; {advice}") from error
    if found != kind or not isinstance(config, dict):
        raise FileError(path, f"is no file of the {kind} network's weights; {advice}")
    state = {name: value.float() if value.is_floating_point() else value for name, value in state.items()}
    if not all(torch.isfinite(value).all() for value in state.values()):
        raise FileError(path, f"holds weights that are not finite; {advice}")
    return config, state


def read_checkpoint(path: Path) -> dict[str, Any] | None:
    """A training's checkpoint, without pickled code; None where there is none.

    Raises:
        FileError: the file is none.
    """
    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
        content["state_dict"], content["epoch"], content["callbacks"]
    except FileNotFoundError:
        return None
    except (OSError, RuntimeError, EOFError, LookupError, TypeError, ValueError, pickle.UnpicklingError) as error:
        raise FileError(path, "is no checkpoint of this training; delete it to begin again") from error
    return dict(content)


@contextlib.contextmanager
def quiet_lightning() -> Iterator[None]:
    """Without what Lightning says at every start: accelerators, other products, and that a run goes on."""
    logger = logging.getLogger("lightning.pytorch")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Checkpoint directory .* exists and is not empty")
            yield
    finally:
        logger.setLevel(level)
