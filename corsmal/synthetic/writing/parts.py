"""Of which parts a recording is made, and where their files are."""

import os
from functools import partial
from pathlib import Path

from corsmal import files
from corsmal.errors import FileError
from corsmal.synthetic.scene.cameras import VIEWS

ANNOTATION_FILE = Path("ccm_demo_annotation.json")
"""In the dataset's folder; lists the recordings that are complete."""

STAGING = ".making"
"""The folder in the dataset's in which files wait until their recording is complete."""

SOUND = "sound"
PARTS = (*VIEWS, SOUND)
"""What can be made apart from the rest of a recording: each view, and the sound with the truth about the scene."""

ADVICE = "free the disk or choose another folder"

writing = partial(files.writing, advice=ADVICE)
"""Write a file of the dataset, whole or not at all."""


def part_files(recording_id: str, part: str, *, compact: bool = False) -> tuple[Path, ...]:
    """Files of a part, relative to the dataset's folder; the sound of a compact recording is a FLAC file."""
    if part == SOUND:
        return Path("audio", f"{recording_id}.{'flac' if compact else 'wav'}"), Path("truth", f"{recording_id}.json")
    return (
        Path(part, "calib", f"{recording_id}.pickle"),
        Path("truth", "amodal", part, f"{recording_id}.parquet"),
        Path("truth", "visible", part, f"{recording_id}.parquet"),
        Path(part, "rgb", f"{recording_id}.mp4"),
    )


def move(file: Path, source: Path, target: Path) -> None:
    """Move a file from one folder to another one of the same disk; one that is not there is no error.

    Args:
        file: relative to both folders.
        source: the folder where it is, unless another process that makes the same dataset was faster.
        target: the other folder.

    Raises:
        FileError: the file cannot be moved.
    """
    try:
        (target / file).parent.mkdir(parents=True, exist_ok=True)
        if (source / file).is_file():
            os.replace(source / file, target / file)
    except FileNotFoundError:
        pass
    except OSError as error:
        raise FileError(target / file, f"cannot be written ({error.strerror}); {ADVICE}") from error
