"""Videos: frames by index, exactly those that reading from the start gives."""

from bisect import bisect_left, bisect_right
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path
from threading import Lock
from types import TracebackType
from typing import Self

import av
import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError, FileError, NotFoundError

FRAMES_KEPT = 16
"""Frames that stay decoded (compressed colours, 1.4 MB each at 1280×720), so that a step back costs no decoding."""


def video_size(path: str | Path) -> tuple[int, int]:
    """Width and height in pixels, from the file's header alone.

    Raises:
        FileError: the file is absent or no video.
    """
    with _opened(Path(path)) as container:
        return _size(container.streams.video[0])


class Video:
    """A video file whose frames are read by index.

    Opening lists the time stamps of the packets without decoding any. A frame is then found by its time stamp: from
    the last key frame at or before it, or by decoding on when that is nearer. Frames count from 0 in the order in which
    they are shown. One instance may be used by several threads.

    Args:
        path: an MP4 file.

    Raises:
        FileError: the file is absent, no MP4 video, or holds no frames.

    Example:
        >>> with Video("train/view3/rgb/000618.mp4") as video:  # doctest: +SKIP
        ...     first, last = video[0], video[-1]  # (H, W, 3) uint8, RGB
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._lock = Lock()
        self._closed = False
        self._next = self._whole_from = 0
        self._kept: OrderedDict[int, av.VideoFrame] = OrderedDict()
        self._container = _opened(self.path)
        try:
            self._stream = self._container.streams.video[0]
            self.size = _size(self._stream)
            self.codec = str(self._stream.codec_context.name)
            self.fps = float(self._stream.average_rate or self._stream.guessed_rate or 0)
            self._list_packets()
            self._rewind()
        except BaseException:
            self._container.close()
            raise

    @property
    def frame_count(self) -> int:
        """Frames in the file, as its packets tell; the last ones of a damaged file may still fail to decode."""
        return len(self._times)

    def __len__(self) -> int:
        return len(self._times)

    def __getitem__(self, index: int) -> NDArray[np.uint8]:
        """One frame, (H, W, 3) uint8 RGB; 0 is the first, -1 the last.

        Raises:
            NotFoundError: there is no such frame.
            FileError: the frame is damaged and cannot be decoded.
        """
        if not isinstance(index, int | np.integer):
            raise ArgumentError(f"index must be a whole number, got {index!r}")
        if not -len(self) <= index < len(self):
            raise NotFoundError(f"{self.path} has {len(self)} frames (0 to {len(self) - 1}), there is no frame {index}")
        with self._lock:
            if self._closed:
                raise ArgumentError(f"the video {self.path} was closed and cannot be read any more")
            frame = self._find(int(index) % len(self))
            return np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8)

    def __iter__(self) -> Iterator[NDArray[np.uint8]]:
        return (self[index] for index in range(len(self)))

    def close(self) -> None:
        """Close the file; frames can no longer be read."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._kept.clear()
                self._container.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _list_packets(self) -> None:
        """Note the time stamps of all frames, and where decoding may start."""
        packets = [
            (packet.pts, packet.dts, packet.is_keyframe, packet.is_discard)
            for packet in _until_damage(self._container.demux(self._stream))
            if packet.size and packet.pts is not None and not packet.is_corrupt
        ]
        self._times = sorted({pts for pts, _, _, is_discard in packets if not is_discard})
        if not self._times:
            raise FileError(self.path, "the video holds no frames; download it again")
        self._index_of = {pts: index for index, pts in enumerate(self._times)}
        keys = sorted((pts, dts if dts is not None else pts) for pts, dts, is_key, _ in packets if is_key)
        self._key_times = [pts for pts, _ in keys]
        self._key_starts = [dts for _, dts in keys]

    def _find(self, index: int) -> av.VideoFrame:
        """The decoded frame: kept, further on, after the last key frame, or at worst by reading from the start."""
        if index in self._kept:
            return self._kept[index]
        key = bisect_right(self._key_times, self._times[index]) - 1
        is_ahead = self._next <= index and (key < 0 or self._times[self._next] >= self._key_times[key])
        if is_ahead and (frame := self._decode_up_to(index)):
            return frame
        if key >= 0 and self._seek(key) and (frame := self._decode_up_to(index)):
            return frame
        self._rewind()
        if frame := self._decode_up_to(index):
            return frame
        raise FileError(self.path, f"frame {index} is damaged and cannot be decoded; download the video again")

    def _decode_up_to(self, index: int) -> av.VideoFrame | None:
        """Decode on until the frame comes; None when it does not."""
        for frame in self._decoded:
            found = -1 if frame.pts is None else self._index_of.get(frame.pts, -1)
            if found < self._whole_from or found in self._kept:
                continue
            self._next = found + 1
            self._kept[found] = frame
            if len(self._kept) > FRAMES_KEPT:
                self._kept.popitem(last=False)
            if found >= index:
                return frame if found == index else None
        self._next = len(self)
        return None

    def _seek(self, key: int) -> bool:
        """Make the key frame of that number the next one to be decoded; False when the file does not lead there."""
        try:
            self._container.seek(self._key_starts[key], stream=self._stream)
            packets = self._container.demux(self._stream)
            first = next(packets)
        except (av.FFmpegError, StopIteration):
            return False
        if first.pts is None or first.pts > self._key_times[key] or not first.is_keyframe:
            return False
        self._begin(chain([first], packets), whole_from=bisect_left(self._times, first.pts))
        return True

    def _rewind(self) -> None:
        """Make the first frame the next one to be decoded; opening anew is what reading from the start means."""
        container = _opened(self.path)
        self._container.close()
        self._container, self._stream = container, container.streams.video[0]
        self._begin(container.demux(self._stream), whole_from=0)

    def _begin(self, packets: Iterator[av.Packet], *, whole_from: int) -> None:
        """Decode these packets next. Frames before ``whole_from`` refer to others that are not among them."""
        self._decoded = self._decode(packets)
        self._whole_from = self._next = whole_from
        self._kept.clear()

    def _decode(self, packets: Iterator[av.Packet]) -> Iterator[av.VideoFrame]:
        """All frames that come out of the packets, past those that are damaged."""
        for packet in chain(_until_damage(packets), [None]):
            try:
                yield from self._stream.codec_context.decode(packet)
            except av.FFmpegError:
                continue


def _until_damage(packets: Iterator[av.Packet]) -> Iterator[av.Packet]:
    """The packets before the first that cannot be read; nothing behind it can."""
    with suppress(av.FFmpegError):
        yield from packets


def _opened(path: Path) -> av.container.InputContainer:
    """The open file. Only the MP4 reader is allowed: others follow addresses that stand in the file."""
    if not path.is_file():
        raise FileError(path, "there is no such video file")
    try:
        container = av.open(f"file:{path}", format="mp4", options={"protocol_whitelist": "file"})
    except (av.FFmpegError, OSError) as error:
        problem = f"cannot be opened as an MP4 video ({error.strerror}); it may be truncated, download it again"
        raise FileError(path, problem) from error
    if not container.streams.video or min(_size(container.streams.video[0])) < 1:
        container.close()
        raise FileError(path, "holds no video, only other content; download it again")
    return container


def _size(stream: av.VideoStream) -> tuple[int, int]:
    return int(stream.codec_context.width), int(stream.codec_context.height)
