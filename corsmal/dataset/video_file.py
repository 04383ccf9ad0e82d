"""Opening video files: which stream is the video, and how its pictures are turned."""

import struct
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

import av
import numpy as np
from av.stream import Disposition
from numpy.typing import NDArray

from corsmal.errors import FileError

FORMATS = {
    ".mp4": "mp4",
    ".mov": "mp4",
    ".m4v": "mp4",
    ".mkv": "matroska",
    ".webm": "matroska",
    ".avi": "avi",
    ".mpg": "mpeg",
    ".mpeg": "mpeg",
}
"""The reader by the ending of a file's name. No other is allowed: some follow addresses that stand in the file."""

PIXELS_MAX = 50_000_000
"""Of a picture; the dataset's have a million."""

Turn = tuple[bool, bool, bool]
"""How a picture is shown: whether it is transposed, then mirrored left to right, then top to bottom."""

_BOXES_MAX = 10_000
_UNTURNED: Turn = (False, False, False)


def open_video(path: Path) -> av.container.InputContainer:
    """The open file, which has a stream that ``video_stream`` returns.

    Raises:
        FileError: the file is absent, no video of a known form, or its pictures are too large.
    """
    if not path.is_file():
        raise FileError(path, "there is no such video file")
    form = FORMATS.get(path.suffix.lower(), "mp4")
    try:
        container = av.open(
            f"file:{path}", format=form, options={"protocol_whitelist": "file"}, metadata_errors="replace"
        )
    except (av.FFmpegError, OSError) as error:
        kind = "an MP4 video" if form == "mp4" else f"a video ({path.suffix})"
        problem = f"cannot be opened as {kind} ({error.strerror}); it may be truncated, download it again"
        raise FileError(path, problem) from error
    try:
        width, height = coded_size(video_stream(container))
    except IndexError:
        width = height = 0
    if min(width, height) < 1:
        container.close()
        raise FileError(path, "holds no video, only other content; download it again")
    if width * height > PIXELS_MAX:
        container.close()
        raise FileError(path, f"has pictures of {width}x{height} pixels, too large to be read; scale them down")
    return container


def frames_beyond_end(path: Path) -> tuple[int, int]:
    """How many frames a video's index names, 0 where it has none, and how many of them lie beyond the end of the file.

    Raises:
        FileError: as of ``open_video``.
    """
    with open_video(path) as container:
        ends = [entry.pos + entry.size for entry in video_stream(container).index_entries]
    size = path.stat().st_size
    return len(ends), sum(end > size for end in ends)


def video_stream(container: av.container.InputContainer) -> av.VideoStream:
    """The stream with the most frames, of those in a known form that are no cover picture.

    Raises:
        IndexError: there is none.
    """
    streams = [
        each
        for each in container.streams.video
        if each.codec_context is not None and not each.disposition & Disposition.attached_pic
    ]
    return sorted(streams, key=lambda stream: -stream.frames)[0]


def coded_size(stream: av.VideoStream) -> tuple[int, int]:
    """Width and height as the pictures are stored."""
    return int(stream.codec_context.width), int(stream.codec_context.height)


def shown_size(stream: av.VideoStream, turn: Turn) -> tuple[int, int]:
    """Width and height as the pictures are shown."""
    width, height = coded_size(stream)
    return (height, width) if turn[0] else (width, height)


def turned(picture: NDArray[np.uint8], turn: Turn) -> NDArray[np.uint8]:
    """A picture, (H, W, 3), as it is shown."""
    if turn == _UNTURNED:
        return picture
    is_transposed, mirrored, upside_down = turn
    picture = picture.transpose(1, 0, 2) if is_transposed else picture
    picture = picture[:, ::-1] if mirrored else picture
    return np.ascontiguousarray(picture[::-1] if upside_down else picture)


def file_turn(path: Path) -> Turn:
    """How the pictures of an MP4 file are turned, by its display matrix; other files are not.

    Players, ffmpeg and OpenCV obey the matrix. PyAV gives it with decoded pictures only, so it is read from the file.
    """
    with suppress(OSError, struct.error), path.open("rb") as file:
        for name, start, end in _boxes(file, 0, path.stat().st_size):
            if name == b"moov":
                tracks = [_track_turn(file, *track) for track in _tracks(file, start, end)]
                return next((turn for turn in tracks if turn is not None), _UNTURNED)
    return _UNTURNED


def _tracks(file: BinaryIO, start: int, end: int) -> list[tuple[int, int]]:
    return [(first, last) for name, first, last in _boxes(file, start, end) if name == b"trak"]


def _track_turn(file: BinaryIO, start: int, end: int) -> Turn | None:
    """How a track is turned; None where it is no video, or nobody knows."""
    matrix, is_video = None, False
    for name, first, last in _boxes(file, start, end):
        if name == b"tkhd":
            file.seek(first)
            version = file.read(1)[0]
            file.seek(first + (52 if version else 40))
            matrix = struct.unpack(">9i", file.read(36))
        if name == b"mdia":
            for inner, place, _ in _boxes(file, first, last):
                if inner == b"hdlr":
                    file.seek(place + 8)
                    is_video = file.read(4) == b"vide"
    return _turn(*matrix[:2], *matrix[3:5]) if is_video and matrix is not None else None


def _turn(a: int, b: int, c: int, d: int) -> Turn:
    """Of a matrix that takes a pixel to (a x + c y, b x + d y)."""
    if abs(b) + abs(c) > abs(a) + abs(d):
        return True, c < 0, b < 0
    return False, a < 0, d < 0


def _boxes(file: BinaryIO, at: int, end: int) -> list[tuple[bytes, int, int]]:
    """Name, first and last byte of what is in each box of a stretch of an MP4 file."""
    found: list[tuple[bytes, int, int]] = []
    while at + 8 <= end and len(found) < _BOXES_MAX:
        file.seek(at)
        size, name = struct.unpack(">I4s", file.read(8))
        head = 8
        if size == 1:
            (size,), head = struct.unpack(">Q", file.read(8)), 16
        size = size or end - at
        if size < head:
            break
        found.append((name, at + head, min(at + size, end)))
        at += size
    return found
