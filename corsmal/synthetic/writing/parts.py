"""Of which parts a recording is made, and where their files are."""

from functools import partial
from pathlib import Path

from corsmal import files
from corsmal.synthetic.scene.cameras import VIEWS

ANNOTATION_FILE = Path("ccm_demo_annotation.json")
"""In the dataset's folder; lists the recordings that are complete."""

STAGING = ".making"
"""The folder in the dataset's in which files wait until their recording is complete."""

SOUND = "sound"
PARTS = (*VIEWS, SOUND)
"""What can be made apart from the rest of a recording: each view, and the sound with the truth about the scene."""

writing = partial(files.writing, advice="free the disk or choose another folder")
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
