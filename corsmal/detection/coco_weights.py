"""Files of published weights, such as Mask R-CNN's for COCO: where they are looked for, and downloading them."""

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
    return weights_file(COCO_WEIGHTS_URL)


def coco_weights() -> Path:
    """The file of the COCO weights, see ``fetched_weights``."""
    return fetched_weights(COCO_WEIGHTS_URL)


def weights_file(url: str) -> Path:
    """Where published weights are looked for, see ``coco_weights_file``."""
    home = os.environ.get("TORCH_HOME") or Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache", "torch")
    folder = os.environ.get("CORSMAL_WEIGHTS") or Path(home, "hub", "checkpoints").expanduser()
    return Path(folder, url.rsplit("/", 1)[-1])


def fetched_weights(url: str) -> Path:
    """The file of published weights, downloaded where it is missing.

    Raises:
        FileError: it cannot be downloaded; the text says which file to put where.
    """
    path = weights_file(url)
    if path.is_file():
        return path
    with writing(path, advice="set CORSMAL_WEIGHTS to another folder") as part:
        try:
            with urllib.request.urlopen(url, timeout=TIMEOUT_S) as response, part.open("wb") as file:
                shutil.copyfileobj(response, file)
        except (OSError, http.client.HTTPException) as error:
            problem = f"is missing and cannot be fetched ({error}); download {url} and put it there"
            raise FileError(path, problem) from error
        if not is_coco(path, file_sha256(part)):
            raise FileError(path, f"arrived damaged from {url}; try again")
    return path


def is_coco(path: Path, sha256: str) -> bool:
    """Whether a file with this SHA-256 is the one that the address names."""
    return sha256.startswith(path.stem.rsplit("-", 1)[-1])
