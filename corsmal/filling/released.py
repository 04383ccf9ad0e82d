"""The filling network of the authors' program: its file, and its answer to a waveform."""

from pathlib import Path

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from corsmal.dataset.audio import CHANNELS
from corsmal.errors import ArgumentError
from corsmal.filling.config import FillingConfig
from corsmal.filling.frontend import LogMelParameters, check_loud, log_mel
from corsmal.filling.network import FillingModel
from corsmal.state_dicts import read_state_dict

POSITIONS = 8000
"""How many positions the file holds; only the first is used."""

NORM = ("weight", "bias", "running_mean", "running_var", "num_batches_tracked")
LAYERS = {"cnn.depthwise.{}": "encoder.dconv.{}"} | {
    f"{own}.{number}.{{}}": f"{theirs}.fc{layer}.{{}}"
    for own, theirs in (("type_head", "classify_head2"), ("level_head", "classify_head1"))
    for number, layer in ((0, 1), (3, 2))
}
"""The file's name of a layer's weight and bias, by ours; ``BLOCK`` within a block."""

BLOCK = {
    "norm_attention.{}": "norm.{}",
    "attention.in_proj_{}": "mhla.qkv.{}",
    "attention.out_proj.{}": "mhla.projection.{}",
    "layers.0.{}": "ffn.fc1.{}",
    "layers.3.{}": "ffn.fc2.{}",
}
TRANSFORMER = "encoder.transformer"
CLS_WEIGHT, CLS_INPUT = (f"{TRANSFORMER}.cls_token_adder.{name}" for name in ("gen_cls_token.weight", "ones"))
POINTWISE, FIRST_POSITIONS = "encoder.pconv.weight", f"{TRANSFORMER}.pe.pos_e"


def read_released(path: Path) -> FillingModel:
    """The network of the authors' file, such as ``task1and2.pt``, ready to predict.

    Raises:
        FileError: the file is absent, broken, of another network, or holds numbers that are not finite.
    """
    model = FillingModel(FillingConfig.released())
    state, names = model.state_dict(), _names(model.config)
    shapes = {theirs: tuple(state[own].shape) for own, theirs in names.items()} | {
        POINTWISE: (1, 2 * CHANNELS, 1, 1),
        CLS_WEIGHT: (model.config.features, 1),
        CLS_INPUT: (1,),
        FIRST_POSITIONS: (POSITIONS, 1, model.config.features),
    }
    content = read_state_dict(path, "filling", shapes)
    state |= {own: content[theirs] for own, theirs in names.items()}
    state["cnn.pointwise.weight"] = content[POINTWISE].flatten(1)
    state["cls"] = content[CLS_WEIGHT] @ content[CLS_INPUT]
    state["first_position"] = content[FIRST_POSITIONS][0, 0]
    model.load_state_dict(state)
    return model.eval()


def logits(
    path: str | Path, waveform: ArrayLike, *, sample_rate_hz: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """What the authors' network says about a waveform, with its own front end.

    Args:
        path: its file, such as ``task1and2.pt``.
        waveform: (8, S) floating samples in -1..1, S at least a window, 2048 at 44,100 Hz.
        sample_rate_hz: of the waveform; another rate than 44,100 Hz is resampled first.

    Returns:
        (4,) logits of none, pasta, rice and water, and (3,) of empty, half and full.

    Raises:
        ArgumentError: the waveform has another form, is too short, or holds digital silence.
        FileError: the file is absent, broken or of another network.

    Example:
        >>> types, levels = logits("task1and2.pt", waveform, sample_rate_hz=44_100)  # doctest: +SKIP
    """
    shape = np.shape(waveform)
    if len(shape) != 2 or shape[0] != CHANNELS:
        raise ArgumentError(f"waveform must have shape ({CHANNELS}, samples), got {shape}")
    model = read_released(Path(path))
    rows = log_mel(waveform, sample_rate_hz=sample_rate_hz, parameters=LogMelParameters.of("released"))
    check_loud(rows)
    with torch.inference_mode():
        types, levels = model(torch.from_numpy(rows)[None])
    return types[0].numpy(), levels[0].numpy()


def _names(config: FillingConfig) -> dict[str, str]:
    """The file's names of the tensors that have the same form in both, by ours."""
    layers = dict(LAYERS)
    for index in range(config.blocks):
        place = f"{TRANSFORMER}." + ("first_block" if index == 0 else f"layer_stack.{index - 1}")
        layers |= {f"blocks.{index}.{own}": f"{place}.{theirs}" for own, theirs in BLOCK.items()}
    names = {own.format(part): theirs.format(part) for own, theirs in layers.items() for part in ("weight", "bias")}
    return (
        names
        | {f"cnn.norm.{part}": f"encoder.norm.{part}" for part in NORM}
        | {"cnn.pointwise.bias": "encoder.pconv.bias"}
    )
