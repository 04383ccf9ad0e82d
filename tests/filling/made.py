"""Small features with a rule that a network can learn: one column says the type, another the level."""

from dataclasses import replace

import numpy as np
import torch

from corsmal.filling import FEASIBLE_PAIRS, FillingConfig, FillingSample, FillingTraining

WIDTH = 16
SMALL = FillingConfig(channels=2, features=WIDTH, heads=2, blocks=2, hidden=16, head_hidden=8, dropout=0.1)

PAPER = FillingTraining((SMALL,), epochs=3, batch=8, rate=1e-3)
JOINT = replace(PAPER, passes="joint", keep="last")


def made_features(rows, *, seed=0, channels=2, width=WIDTH):
    return np.random.default_rng(seed).normal(size=(channels, rows, width)).astype(np.float32)


def made_samples(count, *, seed=0, channels=2):
    """Recordings of 3 to 11 rows that take the feasible pairs in turn, in three containers."""
    rng = np.random.default_rng(seed)
    samples = []
    for index in range(count):
        filling, level = FEASIBLE_PAIRS[index % len(FEASIBLE_PAIRS)]
        features = made_features(int(rng.integers(3, 12)), seed=seed * 1000 + index, channels=channels) * 0.3
        features[..., filling] += 2
        features[..., 8 + level] += 2
        samples.append(FillingSample(f"{index:06d}", 1 + index % 3, features, filling, level))
    return samples


def state(model):
    return {name: value.clone() for name, value in model.state_dict().items()}


def same(first, second):
    return first.keys() == second.keys() and all(torch.equal(first[name], second[name]) for name in first)
