"""Networks in the form of the authors' files, of random numbers, and what they answer, worked out with NumPy alone."""

from collections import OrderedDict
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

Array = NDArray[np.float64]
State = OrderedDict[str, torch.Tensor]

NORM = ("weight", "bias", "running_mean", "running_var")
TRANSFORMER = "encoder.transformer."
BLOCKS = [f"{TRANSFORMER}{name}" for name in ("first_block", "layer_stack.0", "layer_stack.1")]


def filling_shapes() -> dict[str, tuple[int, ...]]:
    shapes: dict[str, tuple[int, ...]] = {f"encoder.norm.{part}": (8,) for part in NORM}
    shapes |= {"encoder.norm.num_batches_tracked": ()}
    shapes |= {"encoder.dconv.weight": (16, 1, 5, 5), "encoder.dconv.bias": (16,)}
    shapes |= {"encoder.pconv.weight": (1, 16, 1, 1), "encoder.pconv.bias": (1,)}
    shapes |= {
        f"{TRANSFORMER}cls_token_adder.ones": (1,),
        f"{TRANSFORMER}cls_token_adder.gen_cls_token.weight": (128, 1),
    }
    shapes |= {f"{TRANSFORMER}pe.pos_e": (8000, 1, 128)}
    for block in BLOCKS:
        shapes |= {f"{block}.norm.weight": (128,), f"{block}.norm.bias": (128,)}
        shapes |= {f"{block}.mhla.qkv.weight": (384, 128), f"{block}.mhla.qkv.bias": (384,)}
        shapes |= {f"{block}.mhla.projection.weight": (128, 128), f"{block}.mhla.projection.bias": (128,)}
        shapes |= {f"{block}.ffn.fc1.weight": (256, 128), f"{block}.ffn.fc1.bias": (256,)}
        shapes |= {f"{block}.ffn.fc2.weight": (128, 256), f"{block}.ffn.fc2.bias": (128,)}
    for head, classes in (("classify_head1", 3), ("classify_head2", 4)):
        shapes |= {f"{head}.fc1.weight": (32, 128), f"{head}.fc1.bias": (32,)}
        shapes |= {f"{head}.fc2.weight": (classes, 32), f"{head}.fc2.bias": (classes,)}
    return shapes


def mass_shapes() -> dict[str, tuple[int, ...]]:
    shapes: dict[str, tuple[int, ...]] = {}
    for number, (before, after) in enumerate(((1, 32), (32, 64), (64, 64), (64, 128)), 1):
        shapes |= {f"conv{number}.weight": (after, before, 3, 3), f"conv{number}.bias": (after,)}
    for number, width in enumerate((32, 64, 64, 128, 64), 1):
        shapes |= {f"bn{number}.{part}": (width,) for part in NORM} | {f"bn{number}.num_batches_tracked": ()}
    for number, (before, after) in enumerate(((6272, 64), (64, 6), (9, 1)), 1):
        shapes |= {f"linear{number}.weight": (after, before), f"linear{number}.bias": (after,)}
    return shapes


SHAPES = {"filling": filling_shapes(), "mass": mass_shapes()}


def random_state(kind: str, *, seed: int = 0) -> State:
    """Tensors whose sizes keep the layers' outputs in a sensible range; variances are positive."""
    generator = torch.Generator().manual_seed(seed)
    state: State = OrderedDict()
    for name, shape in SHAPES[kind].items():
        numbers = torch.randn(shape, generator=generator)
        if name.endswith("num_batches_tracked"):
            state[name] = torch.tensor(7)
        elif name.endswith(("running_var", "ones")):
            state[name] = numbers.abs() + 0.5
        elif "weight" in name and len(shape) == 1:
            state[name] = 1 + 0.1 * numbers
        else:
            state[name] = numbers / np.sqrt(max(1, np.prod(shape[1:])))
    if kind == "mass":
        state["linear3.bias"] += 40  # the output is positive
    return state


def write_released(folder: Path, *, seed: int = 0) -> dict[str, Path]:
    """Both files, by ``filling`` and ``mass``."""
    paths = {"filling": folder / "task1and2.pt", "mass": folder / "task4.pt"}
    for kind, path in paths.items():
        torch.save(random_state(kind, seed=seed), path)
    return paths


def numbers_of(state: State) -> dict[str, Array]:
    return {name: value.double().numpy() for name, value in state.items()}


def linear(x: Array, s: dict[str, Array], name: str) -> Array:
    return x @ s[f"{name}.weight"].T + s[f"{name}.bias"]


def normed(x: Array, s: dict[str, Array], name: str) -> Array:
    """Batch norm of (channels, ...) by the running statistics."""
    mean, var, weight, bias = (
        s[f"{name}.{part}"].reshape(-1, *[1] * (x.ndim - 1))
        for part in ("running_mean", "running_var", "weight", "bias")
    )
    return (x - mean) / np.sqrt(var + 1e-5) * weight + bias


def convolved(x: Array, kernels: Array, bias: Array, *, groups: int) -> Array:
    """(C, H, W) by (out, C / groups, k, k), padded so that the size stays."""
    out, own, size, _ = kernels.shape
    edge = size // 2
    padded = np.pad(x, ((0, 0), (edge, edge), (edge, edge)))
    result = np.zeros((out, *x.shape[1:]))
    for o in range(out):
        first = o // (out // groups) * own
        for c in range(own):
            for dy in range(size):
                for dx in range(size):
                    shifted = padded[first + c, dy : dy + x.shape[1], dx : dx + x.shape[2]]
                    result[o] += kernels[o, c, dy, dx] * shifted
    return result + bias[:, None, None]


def slow_log_mel(waveform: Array) -> Array:
    """(8, S) at 44,100 Hz to (8, T, 128): reflected edges, Hann window, HTK bands, logarithm to the base 2."""
    mels = np.linspace(0, 2595 * np.log10(1 + 22_050 / 700), 130)
    edges_hz = 700 * (10 ** (mels / 2595) - 1)
    bins_hz = np.arange(1025) * 44_100 / 2048
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(2048) / 2048)
    rows = 1 + waveform.shape[1] // 1024
    found = np.empty((len(waveform), rows, 128))
    for channel, samples in enumerate(waveform):
        padded = np.concatenate([samples[1024:0:-1], samples, samples[-2:-1026:-1]])
        for row in range(rows):
            power = np.abs(np.fft.rfft(window * padded[1024 * row : 1024 * row + 2048])) ** 2
            for band in range(128):
                low, middle, high = edges_hz[band : band + 3]
                triangle = np.clip(
                    np.minimum((bins_hz - low) / (middle - low), (high - bins_hz) / (high - middle)), 0, 1
                )
                found[channel, row, band] = np.log2(triangle @ power)
    return found


def slow_filling(state: State, waveform: Array) -> tuple[Array, Array]:
    """(4,) type and (3,) level logits."""
    s = numbers_of(state)
    x = np.maximum(normed(slow_log_mel(waveform), s, "encoder.norm"), 0)
    x = convolved(x, s["encoder.dconv.weight"], s["encoder.dconv.bias"], groups=8)
    x = np.tensordot(s["encoder.pconv.weight"][0, :, 0, 0], x, 1) + s["encoder.pconv.bias"]
    cls = s[f"{TRANSFORMER}cls_token_adder.gen_cls_token.weight"] @ s[f"{TRANSFORMER}cls_token_adder.ones"]
    x = np.vstack([cls, np.maximum(x, 0)]) + s[f"{TRANSFORMER}pe.pos_e"][0]
    for block in BLOCKS:
        x = x + attended(layer_normed(x, s, block), s, block)
        hidden = np.maximum(linear(layer_normed(x, s, block), s, f"{block}.ffn.fc1"), 0) ** 2
        x = x + linear(hidden, s, f"{block}.ffn.fc2")
    answers = [linear(np.maximum(linear(x[0], s, f"{head}.fc1"), 0), s, f"{head}.fc2") for head in HEADS]
    return answers[0], answers[1]


HEADS = ("classify_head2", "classify_head1")


def layer_normed(x: Array, s: dict[str, Array], block: str) -> Array:
    centred = x - x.mean(axis=1, keepdims=True)
    scaled = centred / np.sqrt((centred**2).mean(axis=1, keepdims=True) + 1e-5)
    return scaled * s[f"{block}.norm.weight"] + s[f"{block}.norm.bias"]


def attended(x: Array, s: dict[str, Array], block: str) -> Array:
    queries, keys, values = np.split(linear(x, s, f"{block}.mhla.qkv"), 3, axis=1)
    heads = []
    for head in range(4):
        part = slice(32 * head, 32 * head + 32)
        powers = np.exp(queries[:, part] @ keys[:, part].T / np.sqrt(32))
        heads.append(powers / powers.sum(axis=1, keepdims=True) @ values[:, part])
    return linear(np.hstack(heads), s, f"{block}.mhla.projection")


def slow_mass(state: State, image: Array, dimensions: Array) -> float:
    """Grams."""
    s = numbers_of(state)
    x = image[None].astype(np.float64)
    for number in range(1, 5):
        x = np.maximum(convolved(x, s[f"conv{number}.weight"], s[f"conv{number}.bias"], groups=1), 0)
        x = normed(x, s, f"bn{number}")
        x = x.reshape(len(x), x.shape[1] // 2, 2, x.shape[2] // 2, 2).max(axis=(2, 4))
    hidden = normed(np.maximum(linear(x.ravel(), s, "linear1"), 0), s, "bn5")
    u = np.maximum(linear(hidden, s, "linear2"), 0)
    return float(np.maximum(linear(np.concatenate([u, dimensions]), s, "linear3"), 0)[0])
