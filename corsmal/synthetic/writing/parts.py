"""Of which parts a recording is made, and where their files are; nothing here needs a renderer."""

from contextlib import AbstractContextManager
from pathlib import Path

from corsmal import files as whole_files
from corsmal.synthetic.scene.cameras import VIEWS

DEMO_SIZE = (640, 360)
"""Width and height of the demo's videos, in pixels."""

ANNOTATION_FILE = Path("ccm_demo_annotation.json")
"""In the demo's folder; lists the recordings that are there."""

STAGING = ".making"
"""The folder in the demo's in which files wait until their recording is complete."""

SOUND = "sound"
PARTS = (*VIEWS, SOUND)
"""What can be made apart from the rest of a recording: each view, and the sound with the truth about the scene."""

KERNELS = ("vessels", "limbs")
"""What the renderer takes seconds to compile, the slowest first."""

CACHE_VARIABLE = "NUMBA_CACHE_DIR"
"""The environment variable that names the folder in which compiled kernels are kept."""


def part_files(recording_id: str, part: str) -> tuple[Path, ...]:
    """Files of a part, relative to the dataset's folder."""
    if part == SOUND:
        return Path("audio", f"{recording_id}.wav"), Path("truth", f"{recording_id}.json")
    return (
        Path(part, "calib", f"{recording_id}.pickle"),
        Path("truth", "amodal", part, f"{recording_id}.parquet"),
        Path("truth", "visible", part, f"{recording_id}.parquet"),
        Path(part, "rgb", f"{recording_id}.mp4"),
    )


def writing(path: Path, *, errors: tuple[type[Exception], ...] = ()) -> AbstractContextManager[Path]:
    """A file of the demo that appears whole or not at all, see ``corsmal.files.writing``.

    Raises:
        FileError: the folder or the file cannot be written.
    """
    return whole_files.writing(path, advice="free the disk or choose another folder for the demo", errors=errors)
