"""The frames of a video by number, from the time stamps of its packets, of which none is decoded."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import NamedTuple

import av


class _Packet(NamedTuple):
    """When a packet's picture is shown and decoded, in the unit of the stream, and its place in the file."""

    stamp: int
    start: int
    order: int
    is_key: bool
    is_discard: bool


class FrameIndex:
    """Which frames a video has, and where decoding may start.

    Recorders give two frames one time stamp: both count, in the order of the file.

    Args:
        packets: of the video's stream, all.

    Attributes:
        times: (n,) when each frame is shown, in the unit of the stream, ascending.
        number_of: the first frame of each time stamp.
        key_starts: when each key frame at which decoding may start is decoded, ascending.
        key_numbers: its number, of one that is not shown that of the next frame.
    """

    def __init__(self, packets: Iterable[av.Packet]) -> None:
        stamped = ((packet, stamp_of(packet)) for packet in packets if packet.size and not packet.is_corrupt)
        listed = sorted(
            _Packet(stamp, start_of(packet, stamp), order, packet.is_keyframe, packet.is_discard)
            for order, (packet, stamp) in enumerate(stamped)
            if stamp is not None
        )
        shown = [packet for packet in listed if not packet.is_discard]
        self.times = [packet.stamp for packet in shown]
        self.number_of = {stamp: number for number, stamp in reversed(list(enumerate(self.times)))}
        place_of = {packet.order: number for number, packet in enumerate(shown)}
        counts = Counter((packet.stamp, packet.start) for packet in listed if packet.is_key)
        # key frames that cannot be told from each other are no place to start
        keys = [packet for packet in listed if packet.is_key and counts[packet.stamp, packet.start] == 1]
        self.key_starts = [key.start for key in keys]
        self.key_numbers = [place_of.get(key.order, bisect_left(self.times, key.stamp)) for key in keys]
        self._number_of_key = {
            (key.stamp, key.start): number for key, number in zip(keys, self.key_numbers, strict=True)
        }

    def key_number(self, packet: av.Packet) -> int | None:
        """The number of the frame of a packet at which decoding may start; None where it may not."""
        stamp = stamp_of(packet)
        return None if stamp is None else self._number_of_key.get((stamp, start_of(packet, stamp)))


def stamp_of(packet: av.Packet) -> int | None:
    """When a packet's picture is shown; AVI files say only in which order they are decoded."""
    return packet.pts if packet.pts is not None else packet.dts


def start_of(packet: av.Packet, stamp: int) -> int:
    """When a packet is decoded, as far as it says so."""
    return packet.dts if packet.dts is not None else stamp


def until_damage(packets: Iterator[av.Packet]) -> Iterator[av.Packet]:
    """The packets before the first that cannot be read; nothing behind it can."""
    with suppress(av.FFmpegError):
        yield from packets
