"""Where the COCO weights of Mask R-CNN are: a local file, downloaded once."""

import contextlib
import hashlib
import http.client
import os
import urllib.request
import uuid
from collections.abc import Callable
from pathlib import Path

from corsmal.errors import FileError

COCO_WEIGHTS_URL = "https://download.pytorch.org/models/maskrcnn_resnet50_fpn_coco-bf2d0c1e.pth"
"""torchvision's ``MaskRCNN_ResNet50_FPN_Weights.COCO_V1``; the name ends in the first digits of its SHA-256."""

CHUNK_BYTES = 1 << 20
TIMEOUT_S = 30


def coco_weights_file() -> Path:
    """Where the COCO weights are looked for: in the folder that ``CORSMAL_WEIGHTS`` names, else in PyTorch's own."""
    folder = os.environ.get("CORSMAL_WEIGHTS")
    if not folder:
        import torch  # noqa: PLC0415 - takes seconds

        folder = str(Path(torch.hub.get_dir(), "checkpoints"))
    return Path(folder, COCO_WEIGHTS_URL.rsplit("/", 1)[-1])


def coco_weights(folder: Path, *, progress: Callable[[float], None] | None = None) -> Path:
    """The file of the COCO weights in ``folder``, downloaded when it is not there.

    Args:
        folder: where the file is, or is to be put.
        progress: called during a download with the fraction that is done, 0..1.

    Raises:
        FileError: it cannot be downloaded; the text says which file to put where.
    """
    path = folder / COCO_WEIGHTS_URL.rsplit("/", 1)[-1]
    if path.is_file():
        return path
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _download(part, progress)
        if not file_sha256(part).startswith(path.stem.rsplit("-", 1)[-1]):
            raise FileError(path, f"arrived damaged from {COCO_WEIGHTS_URL}; try again")
        os.replace(part, path)
    except (OSError, http.client.HTTPException) as error:
        raise FileError(
            path, f"is not there and cannot be fetched ({error}); download {COCO_WEIGHTS_URL} and put it there"
        ) from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink()
    return path


def file_sha256(path: Path) -> str:
    """The SHA-256 of a file's content, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _download(target: Path, progress: Callable[[float], None] | None) -> None:
    with urllib.request.urlopen(COCO_WEIGHTS_URL, timeout=TIMEOUT_S) as response, target.open("wb") as file:
        total_bytes = int(response.headers.get("Content-Length") or 0)
        while chunk := response.read(CHUNK_BYTES):
            file.write(chunk)
            if progress is not None and total_bytes:
                progress(min(file.tell() / total_bytes, 1.0))
