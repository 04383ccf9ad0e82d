"""Masks by hand as COCO results, to a file and back: those of a labelling tool serve too."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from corsmal.by_hand.history import MaskHistory
from corsmal.by_hand.record import SOURCE, HandMask
from corsmal.dataset import View
from corsmal.detection import ViewDetections, read_coco_results
from corsmal.detection.rle import counts_from_rle
from corsmal.errors import ArgumentError
from corsmal.files import writing
from corsmal.parameters import CONTAINER_CLASSES
from corsmal.store import Store

AMODAL = "amodal_segmentation"


def export_masks(masks: Mapping[int, HandMask], path: Path, *, video: str = "") -> None:
    """Write one view's masks by hand as a COCO results file; any reader of COCO finds the visible masks in it.

    Each entry also says ``source: by hand``, ``who``, ``when``, ``based_on``, ``accepted`` and the ``video``'s
    fingerprint, and holds the whole outline, if it was drawn, as ``amodal_segmentation``. A frame whose mask is empty
    has no entry.

    Args:
        masks: by frame of the view's video, see ``MaskHistory.masks``.
        path: the file.
        video: see ``MaskHistory.video``.

    Raises:
        FileError: the file cannot be written.
    """
    entries = [_entry(mask, coco, video) for mask in masks.values() for coco in mask.detections().to_coco(mask.frame)]
    with writing(path, advice="choose another folder") as part:
        part.write_text(json.dumps(entries), encoding="utf-8")


def import_masks(
    recording_id: str, view: View, path: Path, *, store: Store, who: str = ""
) -> tuple[int, tuple[str, ...]]:
    """Keep the masks of a COCO file, of whatever form ``read_coco_results`` reads, as masks by hand.

    Of each frame the container's detection of the highest score counts. A mask becomes the newest of its frame; what
    was there can be restored.

    Args:
        recording_id: the recording's id.
        view: whose frames the file numbers.
        path: the file.
        store: keeps the masks.
        who: whose masks they are, where the file does not say.

    Returns:
        How many masks were kept, and sentences on what was not used, and on how the file was read.

    Raises:
        FileError: the file or the video cannot be read.
    """
    with view.video() as video:
        size, frame_count = video.size[::-1], video.frame_count
    found = read_coco_results(path, size=size, frame_count=frame_count)
    history = MaskHistory(recording_id, view, store=store)
    masks, said = _importable(found, _facts_by_frame(path), history.video, who=who, name=path.name)
    for mask in masks:
        history.keep(mask, after=history.frame(mask.frame).version, by="import")
    return len(masks), (*found.problems, *said)


def _importable(
    found: ViewDetections, facts: Mapping[int, Mapping[str, Any]], video: str, *, who: str, name: str
) -> tuple[list[HandMask], list[str]]:
    """The masks that can be kept, and sentences on the others."""
    masks, said = [], []
    for frame, detections in found.items():
        usable = [index for index, label in enumerate(detections.labels) if label in CONTAINER_CLASSES]
        if not usable:
            continue
        index, extra = max(usable, key=lambda place: detections.scores[place]), facts.get(frame, {})
        if extra.get("video") not in (None, "", video):
            said.append(f"frame {frame}: drawn on another video (its fingerprint differs); not imported")
        elif not detections.mask_areas[index]:
            said.append(f"frame {frame}: the mask is empty; not imported")
        else:
            mask = HandMask(
                frame,
                detections.size,
                detections.counts[index],
                _amodal(extra, detections.size),
                label=int(detections.labels[index]),
                tool="import",
                who=str(extra.get("who") or who),
                based_on=str(extra.get("based_on") or name),
                is_accepted=extra.get("accepted", True) is not False,
            )
            masks.append(mask)
    return masks, said


def _entry(mask: HandMask, coco: Mapping[str, Any], video: str) -> dict[str, Any]:
    amodal = {} if mask.amodal is None else {AMODAL: {"size": list(mask.size), "counts": mask.amodal.decode("ascii")}}
    said = {"source": SOURCE, "who": mask.who, "when": mask.when, "based_on": mask.based_on, "video": video}
    return {**coco, **said, "accepted": mask.is_accepted, **amodal}


def _facts_by_frame(path: Path) -> dict[int, Mapping[str, Any]]:
    """What entries that we wrote say besides a detection, by frame; the file was read, hence bounded, before."""
    content = json.loads(path.read_text(encoding="utf-8"))
    entries = content if isinstance(content, list) else []
    ours = [entry for entry in entries if isinstance(entry, dict) and entry.get("source") == SOURCE]
    return {entry["image_id"]: entry for entry in ours if isinstance(entry.get("image_id"), int)}


def _amodal(extra: Mapping[str, Any], size: tuple[int, int]) -> bytes | None:
    try:
        return counts_from_rle(extra[AMODAL], size) if isinstance(extra.get(AMODAL), dict) else None
    except ArgumentError:
        return None
