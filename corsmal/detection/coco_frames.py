"""The frames of entries: how other programs name and number the pictures that they were drawn in."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from corsmal.detection.coco_foreign import scaled
from corsmal.detection.coco_results import Results, whole
from corsmal.detection.rle import Size
from corsmal.errors import ArgumentError

_WRAPPED = re.compile(r"[-_.](jpe?g|png|bmp|webp)\.rf\.\w+$", re.IGNORECASE)
"""Roboflow's addition to the name of a picture."""


_PICTURE_SIZE = re.compile(r"(?<![0-9])[0-9]{2,5}x[0-9]{2,5}(?![0-9])")
"""Such as 1280x720."""


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
        str(image["id"]): _Image(number - first, (1.0, 1.0) if results.is_relative else _scale(image, size))
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
            results.entries[place] = scaled(entry, image.scale) | {"image_id": image.frame}


def _picture_numbers(images: Sequence[Mapping[str, Any]], frame_count: int | None) -> tuple[list[int], str]:
    """A number for each picture, and where it comes from: its file's name, else its id."""
    names = [_file_name(image) for image in images]
    given = ([_given_number(image) for image in images], "number that a picture has as its frame")
    by_id = ([whole(image["id"]) for image in images], "id of a picture")
    by_name = [(numbers, f"{place} of a picture's name") for numbers, place in _numbers_by_place(names)]
    candidates = (given, *by_name, by_id)
    for numbers, origin in candidates:
        found = [number for number in numbers if number is not None]
        is_unique = len(found) == len(set(found)) == len(images)
        if is_unique and (frame_count is None or max(found) <= frame_count):
            return found, origin
    limit = "" if frame_count is None else f" up to {frame_count - 1}"
    raise ArgumentError(
        "names its images in a way that gives no frames: neither a number of each file_name nor each id is a number "
        f"of its own{limit}"
    )


def _given_number(image: Mapping[str, Any]) -> int | None:
    return next((whole(image[key]) for key in ("frame", "frame_id", "frame_number") if key in image), None)


def _numbers_by_place(names: Sequence[str | None]) -> Iterator[tuple[list[int | None], str]]:
    """The numbers in the names of pictures, the last ones first, and what they are called."""
    found = [[] if name is None else _numbers(name) for name in names]
    for place in range(1, max(map(len, found), default=0) + 1):
        what = "last number" if place == 1 else f"number {place} from the end"
        yield [numbers[-place] if len(numbers) >= place else None for numbers in found], what


def _file_name(image: Mapping[str, Any]) -> str | None:
    extra = image.get("extra")
    name = (extra.get("name") if isinstance(extra, dict) else None) or image.get("file_name")
    return name if isinstance(name, str) else None


def _last_number(name: str) -> int | None:
    return next(reversed(_numbers(name)), None)


def _numbers(name: str) -> list[int]:
    """The numbers in the name of a picture, without those that say how large it is."""
    stem = PurePosixPath(name.replace("\\", "/")).name
    stem = _WRAPPED.sub("", re.sub(r"\.(jpe?g|png|bmp|webp|tiff?)$", "", stem, flags=re.IGNORECASE))
    return [int(number) for number in re.findall(r"[0-9]{1,9}", _PICTURE_SIZE.sub("", stem))]


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
