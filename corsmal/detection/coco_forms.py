"""What programs write in COCO's name, in one form: a list of entries whose image_id is a frame.

Ultralytics and Detectron2 write a list of results; CVAT, Label Studio, FiftyOne and Roboflow a dictionary of images,
annotations and categories. They differ in how frames and classes are numbered, and in what ``coco_foreign`` reads.
Where there is one sensible reading it is taken, and named in a note.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from corsmal.detection.coco_classes import CLASS_NAMES, CONSECUTIVE, class_number, class_text
from corsmal.detection.coco_foreign import entries_of, flatten_outlines, read_scores, rename_keys
from corsmal.detection.coco_frames import number_frames, place_images
from corsmal.detection.coco_results import Results, whole
from corsmal.detection.rle import Size

CUP = 47
"""What the only class of a file is taken for when its name says nothing."""


def as_results(content: object, *, size: Size, frame_count: int | None) -> Results:
    """The content of a file of detections as a list of entries.

    Args:
        content: a list of results, one list per frame, or a dictionary with ``annotations`` and, where there are any,
            ``images`` and ``categories``.
        size: (H, W) of the view's images in pixels.
        frame_count: frames of the video, where known: numbers from 1 to it are counted from 1.

    Raises:
        ArgumentError: it is neither, or its pictures cannot be told for frames.
    """
    results = entries_of(content)
    rename_keys(results)
    flatten_outlines(results, size)
    images = content.get("images") if isinstance(content, dict) else None
    if isinstance(images, list) and images:
        place_images(results, images, size, frame_count)
    else:
        number_frames(results, frame_count)
    categories = content.get("categories") if isinstance(content, dict) else None
    names = _category_names(categories) if isinstance(categories, list) else {}
    _number_classes(results, names)
    read_scores(results)
    return results


def _category_names(categories: Sequence[Any]) -> dict[int, str]:
    pairs = [(whole(each.get("id")), each.get("name")) for each in categories if isinstance(each, dict)]
    return {number: name for number, name in pairs if number is not None and isinstance(name, str)}


def _number_classes(results: Results, names: Mapping[int, str]) -> None:
    """Make each category_id COCO's own number, by the names that the file gives, else by how it must have counted."""
    values = [entry.get("category_id") for _, entry in results.mappings()]
    used = {number for value in values if (number := whole(value)) is not None}
    if names:
        meanings = _by_name(used, names, results)
    elif used and min(used) == 0 and max(used) < len(CONSECUTIVE):
        meanings = {number: CONSECUTIVE[number] for number in used}
        results.note("classes are counted from 0 without gaps, as YOLO's are, and were read as COCO's")
    elif not any(whole(value) is not None or isinstance(value, str) for value in values if type(value) is not int):
        return
    else:
        meanings = {number: number for number in used}
        results.note("category_id is text or has a decimal point, and was read as COCO's number or name")
    for place, entry in results.mappings():
        value = entry.get("category_id")
        number = whole(value)
        meant = meanings.get(number) if number is not None else None
        if meant is None and isinstance(value, str):
            meant = class_number(value)
        if meant is not None:
            results.entries[place] = {**entry, "category_id": meant}
        elif number is not None and number in names:
            results.entries[place] = {**entry, "category_id": names[number]}


def _by_name(used: set[int], names: Mapping[int, str], results: Results) -> dict[int, int]:
    meanings = {
        number: found for number in used if number in names and (found := class_number(names[number])) is not None
    }
    unknown = [number for number in sorted(used) if number not in meanings]
    if len(used) == 1 and unknown and unknown[0] in names:
        meanings[unknown[0]] = CUP
        results.note(f"its only class, {names[unknown[0]][:40]!r}, was taken for a cup")
    changed = [number for number, meant in sorted(meanings.items()) if names[number].lower() != CLASS_NAMES[meant]]
    renumbered = [number for number, meant in sorted(meanings.items()) if number != meant]
    if changed or renumbered:
        shown = [
            f"{names[number][:40]} is {class_text(meanings[number])}" for number in dict.fromkeys(changed + renumbered)
        ]
        results.note(f"classes were read by name: {', '.join(shown[:5])}")
    return meanings
