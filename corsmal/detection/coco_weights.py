"""The file of Mask R-CNN's weights for COCO: where it is looked for, and downloading it, without PyTorch."""

import http.client
import os
import shutil
import urllib.request
from pathlib import Path

from corsmal.errors import FileError
from corsmal.files import writing
from corsmal.weights import file_sha256

COCO_WEIGHTS_URL = "https://download.pytorch.org/models/maskrcnn_resnet50_fpn_coco-bf2d0c1e.pth"
"""torchvision's ``MaskRCNN_ResNet50_FPN_Weights.COCO_V1``; the name ends in the first digits of its SHA-256."""

TIMEOUT_S = 30


def coco_weights_file() -> Path:
    """Where the COCO weights are looked for: in the folder that ``CORSMAL_WEIGHTS`` names, else in PyTorch's own."""
    home = os.environ.get("TORCH_HOME") or Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache", "torch")
    folder = os.environ.get("CORSMAL_WEIGHTS") or Path(home, "hub", "checkpoints").expanduser()
    return Path(folder, COCO_WEIGHTS_URL.rsplit("/", 1)[-1])


def coco_weights() -> Path:
    """The file of the COCO weights, downloaded where it is missing.

    Raises:
        FileError: it cannot be downloaded; the text says which file to put where.
    """
    path = coco_weights_file()
    if path.is_file():
        return path
    with writing(path, advice="set CORSMAL_WEIGHTS to another folder") as part:
        try:
            with urllib.request.urlopen(COCO_WEIGHTS_URL, timeout=TIMEOUT_S) as response, part.open("wb") as file:
                shutil.copyfileobj(response, file)
        except (OSError, http.client.HTTPException) as error:
            problem = f"is missing and cannot be fetched ({error}); download {COCO_WEIGHTS_URL} and put it there"
            raise FileError(path, problem) from error
        if not is_coco(path, file_sha256(part)):
            raise FileError(path, f"arrived damaged from {COCO_WEIGHTS_URL}; try again")
    return path


def is_coco(path: Path, sha256: str) -> bool:
    """Whether a file with this SHA-256 is the one that the address names."""
    return sha256.startswith(path.stem.rsplit("-", 1)[-1])
