"""What the demo's filling network is trained and tested on: log-mel rows of generated sound, without any picture."""

import itertools
import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from corsmal.errors import ArgumentError, FileError
from corsmal.filling import log_mel
from corsmal.synthetic.scene.containers import ANNOTATED_IDS, demo_container
from corsmal.synthetic.scene.scene import BOX_FILLINGS, ROUND_FILLINGS, Scene, sound_events, training_scene
from corsmal.synthetic.sound.recording import recording_sound
from corsmal.synthetic.writing.parts import ANNOTATION_FILE, writing
from corsmal.synthetic.writing.plan import annotation_of

FEATURES_FOLDER = "features"


def filling_scenes(
    seed: int, *, recordings_per_filling: int = 12, containers: Sequence[int] = ANNOTATED_IDS
) -> tuple[Scene, ...]:
    """Scenes that hold each container with each of its fillings equally often, as the real training set does.

    Args:
        seed: a whole number from 0 to 999; no seed gives one of the demo's own scenes.
        recordings_per_filling: of each pair of type and level that a container can hold, the empty one included; 12
            gives the nine containers the 684 recordings of the real set.
        containers: numbers of the containers, 1 to 15.

    Raises:
        ArgumentError: a number is out of its range, or no container is named.
        NotFoundError: there is no such container.
    """
    if not 0 <= seed < 1000 or recordings_per_filling < 1 or not containers:
        raise ArgumentError(
            "seed must lie in 0..999, recordings_per_filling must be at least 1 and containers not empty, "
            f"got {seed}, {recordings_per_filling} and {tuple(containers)}"
        )
    scenes = []
    for container in containers:
        fillings = ROUND_FILLINGS if demo_container(container).is_round else BOX_FILLINGS
        found: Counter[tuple[int, int]] = Counter()
        for number in itertools.count((seed * 1000 + container) * 10**6):
            scene = training_scene(number, containers=[container])
            filling = (scene.filling_type, scene.filling_level)
            if found[filling] < recordings_per_filling:
                found[filling] += 1
                scenes.append(scene)
            if found.total() == recordings_per_filling * len(fillings):
                break
    return tuple(scenes)


def write_filling_data(
    folder: str | Path,
    *,
    seed: int,
    recordings_per_filling: int = 12,
    containers: Sequence[int] = ANNOTATED_IDS,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write a dataset that has an annotation, and features instead of sound; what a stopped call left is kept.

    Args:
        folder: gets the annotation and ``features/ID.npy``, each (8, T, 128) float16 log-mel rows.
        seed: as for ``filling_scenes``.
        recordings_per_filling: likewise.
        containers: likewise; training takes the nine of the real training set and no other.
        progress: called with the numbers of recordings done and wanted.

    Returns:
        The folder with the features.

    Raises:
        ArgumentError: a number is out of its range, or no container is named.
        FileError: a file cannot be written, or the folder holds something else.
    """
    folder = Path(folder)
    scenes = filling_scenes(seed, recordings_per_filling=recordings_per_filling, containers=containers)
    names = [f"{index:06d}" for index in range(len(scenes))]
    _claim(folder / ANNOTATION_FILE, annotation_of(zip(names, scenes, strict=True)), seed)
    for done, (name, scene) in enumerate(zip(names, scenes, strict=True), start=1):
        path = folder / FEATURES_FOLDER / f"{name}.npy"
        if not path.is_file():
            # the demo's own recordings draw their sound in the same way
            sound = recording_sound(sound_events(scene), rng=np.random.default_rng([scene.seed, 3]))
            with writing(path) as part:
                np.save(part, log_mel(sound).astype(np.float16))
        if progress:
            progress(done, len(scenes))
    return folder / FEATURES_FOLDER


def _claim(path: Path, annotation: dict[str, Any], seed: int) -> None:
    """Write the annotation, or make sure that the one which is there is the same."""
    annotation["info"]["seed"] = seed
    text = json.dumps(annotation)
    try:
        found = path.read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError):
        found = None
    except (OSError, ValueError) as error:
        raise FileError(path, "cannot be read; choose another folder") from error
    if found is None:
        with writing(path) as part:
            part.write_text(text, encoding="utf-8")
    elif found != text:
        raise FileError(path, "describes other recordings; choose another folder")
