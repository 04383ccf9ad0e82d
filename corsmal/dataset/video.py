"""Videos: frames by index, exactly those that reading from the start gives."""

from bisect import bisect_right
from collections import OrderedDict
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from threading import Lock
from types import TracebackType
from typing import Self

import av
import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.frame_index import FrameIndex, until_damage
from corsmal.dataset.video_file import file_turn, open_video, shown_size, turned, video_stream
from corsmal.errors import ArgumentError, FileError, NotFoundError

FRAMES_KEPT = 16
"""Frames that stay decoded (compressed colours, 1.4 MB each at 1280×720), so that a step back costs no decoding."""


def video_size(path: str | Path) -> tuple[int, int]:
    """Width and height in pixels as the pictures are shown, from the file's header only.

    Raises:
        FileError: the file is absent or no video.
    """
    path = Path(path)
    with open_video(path) as container:
        return shown_size(video_stream(container), file_turn(path))


def frame_times_s(path: str | Path, *, exactly: bool = True) -> NDArray[np.float64]:
    """(n,) when each frame of a video is shown, seconds, ascending.

    Args:
        path: a video file.
        exactly: as the packets say, for which the file is read; else, where it has an index, as that says, in which
            all times may be a few frames early.

    Raises:
        FileError: the file is absent, no video, or holds no frames.
    """
    path = Path(path)
    if not exactly:
        with open_video(path) as container:
            stream = video_stream(container)
            stamps = sorted(entry.timestamp for entry in stream.index_entries)
            if stamps and len(stamps) == stream.frames:
                started = np.array(stamps, dtype=np.float64) - stamps[0] + (stream.start_time or 0)
                return started * float(stream.time_base or 0)
    with Video(path) as video:
        return video.times_s


class Video:
    """A video file whose frames are read by index.

    Opening lists the time stamps of the packets without decoding any. A frame is then found by its time stamp: from
    the last key frame at or before it, or by decoding on when that is nearer. Frames count from 0 in the order in which
    they are shown, and are turned as the file says, as in OpenCV and ffmpeg. An AVI file says only in which order its
    packets are decoded: where that is not the order in which they are shown, frames are counted as they come out of the
    decoder. One instance may be used by several threads.

    Args:
        path: an MP4 file, or one of the other forms of ``video_file.FORMATS``.

    Raises:
        FileError: the file is absent, no video, or holds no frames.

    Example:
        >>> with Video("train/view3/rgb/000618.mp4") as video:  # doctest: +SKIP
        ...     first, last = video[0], video[-1]  # (H, W, 3) uint8, RGB
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._lock = Lock()
        self._closed = False
        self._next = self._whole_from = 0
        self._last = -1
        self._kept: OrderedDict[int, av.VideoFrame] = OrderedDict()
        self._container = open_video(self.path)
        try:
            self._stream = video_stream(self._container)
            self._turn = file_turn(self.path)
            self.size = shown_size(self._stream, self._turn)
            self.codec = str(self._stream.codec_context.name)
            self.fps = float(self._stream.average_rate or self._stream.guessed_rate or 0)
            self._is_counted = self._container.format.name == "avi" and self._stream.codec_context.has_b_frames
            self._index = FrameIndex(until_damage(self._container.demux(self._stream)))
            self._times = self._index.times
            if not self._times:
                raise FileError(self.path, "the video holds no frames; download it again")
            self._rewind()
        except BaseException:
            self._container.close()
            raise

    @property
    def times_s(self) -> NDArray[np.float64]:
        """(n,) when each frame is shown, seconds, ascending; the first need not be 0."""
        return np.array(self._times, dtype=np.float64) * float(self._stream.time_base or 0)

    @property
    def frame_count(self) -> int:
        """Frames in the file, as its packets tell; the last ones of a damaged file may still fail to decode."""
        return len(self)

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
            frame = self._find(self._own(int(index) % len(self)))
            try:
                picture = frame.to_ndarray(format="rgb24")
            except (av.FFmpegError, ValueError) as error:
                raise FileError(self.path, f"frame {index} has no picture; download the video again") from error
            return turned(np.asarray(picture, dtype=np.uint8), self._turn)

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

    def _own(self, index: int) -> int:
        """The file's frame that is shown as a frame of this video."""
        return index

    def _find(self, index: int) -> av.VideoFrame:
        """The decoded frame: kept, further on, after the last key frame, or at worst by reading from the start."""
        if index in self._kept:
            return self._kept[index]
        key = bisect_right(self._index.key_numbers, index) - 1
        is_ahead = self._next <= index and (key < 0 or self._next >= self._index.key_numbers[key])
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
            found = self._number(frame)
            if found < self._whole_from or found in self._kept:
                continue
            self._next = found + 1
            self._kept[found] = frame
            if len(self._kept) > FRAMES_KEPT:
                self._kept.popitem(last=False)
            if found >= index:
                return frame if found == index else None
        self._next = len(self._times)
        return None

    def _number(self, frame: av.VideoFrame) -> int:
        """The index of a decoded frame, −1 where it has none; of frames with one time stamp each is the next."""
        if self._is_counted:
            self._last = max(self._last + 1, self._whole_from)
            return self._last
        stamp = frame.pts if frame.pts is not None else frame.dts
        found = -1 if stamp is None else self._index.number_of.get(stamp, -1)
        if found < 0:
            return found
        is_next = (
            0 <= self._last < len(self._times) - 1 and self._times[self._last] == self._times[self._last + 1] == stamp
        )
        if is_next:
            found = self._last + 1
        elif self._times[self._whole_from] == stamp:
            found = max(found, self._whole_from)
        self._last = found
        return found

    def _seek(self, key: int) -> bool:
        """Make the key frame of that number the next one to be decoded; False when the file does not lead there."""
        try:
            self._container.seek(self._index.key_starts[key], stream=self._stream)
            packets = self._container.demux(self._stream)
            first = next(packets)
        except (av.FFmpegError, StopIteration):
            return False
        place = self._index.key_number(first) if first.is_keyframe else None
        if place is None or place > self._index.key_numbers[key]:
            return False
        self._begin(chain([first], packets), whole_from=place)
        return True

    def _rewind(self) -> None:
        """Make the first frame the next one to be decoded; opening anew is what reading from the start means."""
        container = open_video(self.path)
        self._container.close()
        self._container, self._stream = container, video_stream(container)
        self._begin(container.demux(self._stream), whole_from=0)

    def _begin(self, packets: Iterator[av.Packet], *, whole_from: int) -> None:
        """Decode these packets next. Frames before ``whole_from`` refer to others that are not among them."""
        self._decoded = self._decode(packets)
        self._whole_from = self._next = min(whole_from, len(self._times) - 1)
        self._last = -1
        self._kept.clear()

    def _decode(self, packets: Iterator[av.Packet]) -> Iterator[av.VideoFrame]:
        """All frames that come out of the packets, past those that are damaged unless frames are counted."""
        for packet in chain(until_damage(packets), [None]):
            try:
                yield from self._stream.codec_context.decode(packet)
            except av.FFmpegError:
                if self._is_counted:
                    return
