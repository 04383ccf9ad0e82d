"""What every filling network is given: features of recordings, padded to one length, and the mask of their rows."""

import torch
from torch import Tensor

from corsmal.errors import ArgumentError


def checked_mask(features: Tensor, mask: Tensor | None, *, channels: int, width: int) -> Tensor:
    """The mask of a batch; all rows where there is none.

    Args:
        features: (B, C, T, features), to be of these ``channels`` and this ``width``.
        mask: (B, T) bool, true on a recording's own rows.
        channels: C.
        width: features per row.

    Raises:
        ArgumentError: features or mask have another form, or a recording has no row.
    """
    if features.ndim != 4 or (features.shape[1], features.shape[3]) != (channels, width):
        raise ArgumentError(f"features must be (B, {channels}, T, {width}), got {tuple(features.shape)}")
    lengths = (features.shape[0], features.shape[2])
    if mask is None:
        mask = torch.ones(lengths, dtype=torch.bool, device=features.device)
    if mask.shape != lengths or mask.dtype != torch.bool:
        raise ArgumentError(f"mask must be {lengths} of bool, got {tuple(mask.shape)} of {mask.dtype}")
    if not mask.any(dim=1).all():
        raise ArgumentError("features must have at least one row in every recording")
    return mask
