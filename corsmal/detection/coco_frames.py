"""The frames of entries: how other programs name and number the pictures that they were drawn in."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from corsmal.detection.coco_results import Results, whole
from corsmal.detection.rle import Size
from corsmal.errors import ArgumentError

_WRAPPED = re.compile(r"[-_.](jpe?g|png|bmp|webp)\.rf\.\w+$", re.IGNORECASE)
"""Roboflow's addition to the name of a picture."""


@dataclass(frozen=True)
class _Image:
    """A picture that a dictionary names: its frame, and what its outlines are scaled by, (x, y)."""

    frame: int
    scale: tuple[float, float]


def number_frames(results: Results, frame_count: int | None) -> None:
    """Make each image_id of a list a frame."""
    named = [entry.get("image_id") for _, entry in results.mappings() if type(entry.get("image_id")) is not int]
    numbers: dict[int, int] = {}
    for place, entry in results.mappings():
        value = entry.get("image_id")
        number = whole(value)
        if number is None and isinstance(value, str):
            number = _last_number(value)
        if number is not None:
            numbers[place] = number
    read = [value for value in named if whole(value) is None and isinstance(value, str) and _last_number(value)]
    if read:
        results.note(f"image_id is text such as {str(read[0])[:40]!r}, the last number in it was read as the frame")
    elif any(whole(value) is not None for value in named):
        results.note("image_id is written as text or with a decimal point, and was read as a whole number")
    first = _first_frame(numbers.values(), frame_count, results)
    if first or named:
        for place, number in numbers.items():
            results.entries[place] = {**results.entries[place], "image_id": number - first}


def place_images(results: Results, images: Sequence[Any], size: Size, frame_count: int | None) -> None:
    """Make each image_id the frame of the picture that it names, and scale what was drawn in a smaller picture."""
    known = [image for image in images if isinstance(image, dict) and image.get("id") is not None]
    numbers, origin = _picture_numbers(known, frame_count)
    first = _first_frame(numbers, frame_count, results)
    by_id = {
        str(image["id"]): _Image(number - first, _scale(image, size))
        for image, number in zip(known, numbers, strict=True)
    }
    results.note(f"a dictionary of {len(known)} images: the {origin} was read as the frame")
    scales = {image.scale for image in by_id.values()} - {(1.0, 1.0)}
    if scales:
        results.note(f"outlines were drawn in pictures of another size and scaled to {size[1]}x{size[0]}")
    for place, entry in results.mappings():
        image = by_id.get(str(entry.get("image_id")))
        if image is None:
            results.entries[place] = {**entry, "image_id": "an image that is not listed"}
        else:
            results.entries[place] = _scaled(entry, image.scale) | {"image_id": image.frame}


def _picture_numbers(images: Sequence[Mapping[str, Any]], frame_count: int | None) -> tuple[list[int], str]:
    """A number for each picture, and where it comes from: its file's name, else its id."""
    names = [_file_name(image) for image in images]
    candidates = (
        ([None if name is None else _last_number(name) for name in names], "last number of a picture's name"),
        ([whole(image["id"]) for image in images], "id of a picture"),
    )
    for numbers, origin in candidates:
        found = [number for number in numbers if number is not None]
        is_unique = len(found) == len(set(found)) == len(images)
        if is_unique and (frame_count is None or max(found) <= frame_count):
            return found, origin
    limit = "" if frame_count is None else f" up to {frame_count - 1}"
    raise ArgumentError(
        "names its images in a way that gives no frames: neither the last number of each file_name nor each id is a "
        f"number of its own{limit}"
    )


def _file_name(image: Mapping[str, Any]) -> str | None:
    extra = image.get("extra")
    name = (extra.get("name") if isinstance(extra, dict) else None) or image.get("file_name")
    return name if isinstance(name, str) else None


def _last_number(name: str) -> int | None:
    stem = PurePosixPath(name.replace("\\", "/")).name
    stem = _WRAPPED.sub("", re.sub(r"\.(jpe?g|png|bmp|webp|tiff?)$", "", stem, flags=re.IGNORECASE))
    found = re.findall(r"[0-9]{1,9}", stem)
    return int(found[-1]) if found else None


def _first_frame(numbers: Iterable[int], frame_count: int | None, results: Results) -> int:
    """The number of the first frame: 1 where the numbers end one behind the last frame and 0 does not occur."""
    found = set(numbers)
    if not found or frame_count is None or min(found) < 1 or max(found) != frame_count:
        return 0
    results.note(f"frames are counted from 1 (up to {frame_count}) and were read as counted from 0")
    return 1


def _scale(image: Mapping[str, Any], size: Size) -> tuple[float, float]:
    width, height = (whole(image.get(name)) or 0 for name in ("width", "height"))
    return (size[1] / width, size[0] / height) if width > 0 and height > 0 else (1.0, 1.0)


def _scaled(entry: dict[str, Any], scale: tuple[float, float]) -> dict[str, Any]:
    """The entry with its polygons and its box scaled; run lengths are for one size and stay."""
    if scale == (1.0, 1.0):
        return dict(entry)
    result = dict(entry)
    polygons, box = entry.get("segmentation"), entry.get("bbox")
    if isinstance(polygons, list):
        result["segmentation"] = [_times(part, scale) if isinstance(part, list) else part for part in polygons]
    if isinstance(box, list):
        result["bbox"] = _times(box, scale)
    return result


def _times(values: Sequence[Any], scale: tuple[float, float]) -> list[Any]:
    return [
        value * scale[place % 2] if type(value) in (int, float) and abs(value) < 1e9 else value
        for place, value in enumerate(values)
    ]
