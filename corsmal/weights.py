"""Networks in files: which file is used, what it was trained on, reading and writing it, and the device it runs on."""

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from corsmal.errors import ArgumentError, FileError
from corsmal.files import check_plain_file, writing
from corsmal.state_dicts import is_state_dict

if TYPE_CHECKING:
    import torch
    from torch import nn

Kind = Literal["detector", "filling", "mass"]
Origin = Literal["named", "environment", "bundled"]
Facts = Mapping[str, Any]
Network = TypeVar("Network", bound="nn.Module")

BUNDLED = Path(__file__).parent / "demo" / "weights"
"""The folder with the networks of the demo, a file for each kind; a card beside each says what it was trained on."""

ENTRY = "corsmal"
"""The entry of a file's metadata that says which network it is, of which sizes, and what it was trained on."""

BUNDLED_NAME = "demo"
"""Names the bundled file where another one is set in the environment."""

NOT_FINITE = "holds weights that are not finite"

RELEASED = "released "
"""Begins the digest of a network in the authors' own file, which does not say what it was trained on."""


@dataclass(frozen=True)
class WeightsFile:
    """A file of weights, and why it is this one. The file may be absent; reading it says so.

    Args:
        kind: the network that it belongs to.
        path: absolute.
        origin: ``named`` by the caller, by the ``environment``, or ``bundled`` with the library.
    """

    kind: Kind
    path: Path
    origin: Origin

    @property
    def is_bundled(self) -> bool:
        """Whether it is the library's own file, however it was named: one trained on synthetic recordings only."""
        return self.path == bundled_path(self.kind)


def bundled_path(kind: Kind) -> Path:
    """The library's own weights of a network."""
    return BUNDLED / f"{kind}.safetensors"


def find_weights(kind: Kind, named: str | Path | None = None) -> WeightsFile:
    """The weights that a network is read from: the named file, else the environment's, else the bundled one.

    The environment's variables are ``CORSMAL_DETECTOR_WEIGHTS`` (of the demo's small detector),
    ``CORSMAL_FILLING_WEIGHTS`` and ``CORSMAL_MASS_WEIGHTS``.

    Args:
        kind: which network.
        named: a file, or ``demo`` for the bundled one.

    Example:
        >>> find_weights("mass", "demo").is_bundled
        True
    """
    set_file = os.environ.get(f"CORSMAL_{kind.upper()}_WEIGHTS")
    choices: tuple[tuple[Origin, str | Path | None], ...] = (("named", named), ("environment", set_file))
    for origin, given in choices:
        if given:
            is_demo = str(given) == BUNDLED_NAME
            return WeightsFile(kind, bundled_path(kind) if is_demo else Path(given).expanduser().absolute(), origin)
    return WeightsFile(kind, bundled_path(kind), "bundled")


def file_sha256(path: Path) -> str:
    """The SHA-256 of a file's content, hexadecimal."""
    check_plain_file(path)
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def network_digest(kind: Kind, path: Path) -> str:
    """What names a network in rows and keys: its kind and the SHA-256 of its file, after ``RELEASED`` if it is theirs.

    Raises:
        FileError: the file cannot be read.
    """
    try:
        return f"{RELEASED if is_state_dict(path) else ''}{kind} network {file_sha256(path)}"
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror or error}); {_advice(kind)}") from error


def save_network(
    path: Path, network: "nn.Module", *, kind: Kind, config: Any, training: Facts | None = None, half: bool = False
) -> None:
    """Write a network's weights in one file with its config and what it was trained on, both as JSON can hold them.

    Args:
        path: the file, ``.safetensors``.
        network: whose state is written.
        kind: which network it is; ``read_network`` checks it.
        config: its sizes.
        training: what it was trained on.
        half: write the parameters in half precision. Buffers, such as the statistics of inputs, keep theirs.

    Raises:
        FileError: the file cannot be written.
    """
    import safetensors.torch  # noqa: PLC0415 - loads PyTorch, which takes seconds

    parameters = dict(network.named_parameters())
    state = {
        name: (value.half() if half and name in parameters else value).detach().cpu().contiguous()
        for name, value in network.state_dict().items()
    }
    # one entry: the order of several is drawn anew by every process, and so would be the file's digest
    metadata = {ENTRY: json.dumps({"kind": kind, "config": config, "training": dict(training or {})})}
    with writing(path, advice="choose another folder", errors=(safetensors.SafetensorError,)) as part:
        safetensors.torch.save_file(state, part, metadata)


def read_network(path: Path, kind: Kind, build: Callable[[Any], Network]) -> Network:
    """The network of a file that ``save_network`` wrote, in single precision and ready to predict.

    Args:
        path: the file.
        kind: which network it must be of.
        build: makes the network from its config; JSON's lists have become tuples.

    Raises:
        FileError: the file is absent, broken, of another network, or holds weights that are not finite.
    """
    import safetensors.torch  # noqa: PLC0415 - as above
    import torch  # noqa: PLC0415

    try:
        network = build(read_metadata(path, kind)[0])
        state = safetensors.torch.load_file(path)
    except (OSError, safetensors.SafetensorError, TypeError, ValueError, LookupError, RuntimeError) as error:
        raise _foreign(path, kind) from error
    try:
        network.load_state_dict(state)
    except RuntimeError as error:
        raise FileError(path, f"holds weights that do not fit the sizes it names; {_advice(kind)}") from error
    if not all(torch.isfinite(value).all() for value in state.values()):
        raise FileError(path, f"{NOT_FINITE}; {_advice(kind)}")
    return network.eval()


def read_training(path: Path, kind: Kind) -> dict[str, Any]:
    """What a network was trained on, as ``save_network`` was given it; empty where the file does not say.

    Raises:
        FileError: it is absent, broken or of another network.
    """
    return {} if is_state_dict(path) else read_metadata(path, kind)[1]


def read_metadata(path: Path, kind: Kind) -> tuple[Any, dict[str, Any]]:
    """The config, with tuples for lists, and what the network was trained on; errors as for ``read_training``."""
    import safetensors  # noqa: PLC0415 - only for those who read networks

    try:
        check_plain_file(path)
        with safetensors.safe_open(path, "np") as file:
            metadata = file.metadata() or {}
        # networks written before there was a record of the training have an entry for each part, or only the config
        content = json.loads(metadata[ENTRY]) if ENTRY in metadata else _early_content(metadata)
        found, config, training = content["kind"], content["config"], content["training"]
    except (OSError, safetensors.SafetensorError, LookupError, TypeError, ValueError) as error:
        raise _foreign(path, kind) from error
    if found != kind or not isinstance(training, dict):
        raise _foreign(path, kind)
    return _tuples(config), training


def check_network_file(path: Path, kind: Kind) -> None:
    """Whether a file holds a network of a kind and finite numbers, without PyTorch; of the authors' files the format.

    Raises:
        FileError: as ``read_network``, but for weights that do not fit the sizes.
    """
    import numpy as np  # noqa: PLC0415 - as above
    import safetensors  # noqa: PLC0415

    if is_state_dict(path):
        return
    read_metadata(path, kind)
    try:
        with safetensors.safe_open(path, "np") as file:
            is_finite = all(np.isfinite(file.get_tensor(name)).all() for name in file.keys())  # noqa: SIM118 - no mapping
    except (OSError, safetensors.SafetensorError, TypeError, ValueError) as error:
        raise _foreign(path, kind) from error
    if not is_finite:
        raise FileError(path, f"{NOT_FINITE}; {_advice(kind)}")


def _early_content(metadata: Mapping[str, str]) -> dict[str, Any]:
    config, training = metadata.get("config") or metadata["filling"], metadata.get("training", "{}")
    return {"kind": metadata.get("kind", "filling"), "config": json.loads(config), "training": json.loads(training)}


def _tuples(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _tuples(item) for name, item in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _foreign(path: Path, kind: Kind) -> FileError:
    return FileError(path, f"is not a file of the {kind} network's weights; {_advice(kind)}")


def _advice(kind: Kind) -> str:
    return f"train one with `python -m corsmal train {kind}`, or use the bundled file"


def choose_device(name: str | None = None, *, prefer_gpu: bool = False) -> "torch.device":
    """The device of that name, such as ``cuda:0``; by default the CPU, or a GPU where it is preferred and there is one.

    Raises:
        ArgumentError: there is no such device.
    """
    import torch  # noqa: PLC0415 - as above

    try:
        device = torch.device(name or ("cuda" if prefer_gpu and torch.cuda.is_available() else "cpu"))
        torch.empty(1, device=device)
    except (RuntimeError, AssertionError) as error:
        raise ArgumentError(f"device {name!r} cannot be used: {str(error).splitlines()[0]}") from error
    return device
