"""The header of a WAV file, where it does not say what was recorded: recorders die, forget it, or write it wrongly."""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

RIFF, WAVE = b"RIFF", b"WAVE"
CHUNKS_MAX = 1_000
"""Before the samples; a WAV has a handful."""

CHANNELS_MAX, RATE_MAX_HZ = 1_024, 1_000_000
"""What a header may say; with more it is left to the library."""

OPEN_SIZES = (0, 0xFFFFFFFF)
"""What stands for the size of the samples until the recorder closes the file."""

REST_MIN_S = 0.05
"""What follows the samples and is no chunk counts as sound from this length on."""

_SUBTYPES = {
    (1, 8): "PCM_U8",
    (1, 16): "PCM_16",
    (1, 24): "PCM_24",
    (1, 32): "PCM_32",
    (3, 32): "FLOAT",
    (3, 64): "DOUBLE",
}
_EXTENSIBLE = 0xFFFE


@dataclass(frozen=True)
class WavRepair:
    """Where the samples of a WAV file are whose header cannot be followed, and in what form.

    Args:
        start: first byte of the samples.
        end: byte behind the last whole one.
        sentence: what is wrong with the header.
    """

    start: int
    end: int
    channels: int
    sample_rate_hz: int
    subtype: str
    sentence: str

    @property
    def values(self) -> int:
        """Samples of all channels."""
        return (self.end - self.start) // _BYTES[self.subtype]


def find_repair(path: Path) -> WavRepair | None:
    """What has to be done to read a WAV file to its end; None where its header can be followed, or it is no WAV."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(12)
        if head[:4] != RIFF or head[8:] != WAVE:
            return None
        return _walk(file, size)


def _walk(file: BinaryIO, size: int) -> WavRepair | None:
    at, form, is_unpadded = 12, None, False
    for _ in range(CHUNKS_MAX):
        name, length = _chunk(file, at)
        if not _is_name(name):
            return None
        if name == b"data":
            return None if form is None else _repair(file, form, at + 8, length, size, is_unpadded=is_unpadded)
        if name == b"fmt ":
            form = _form(file.read(min(length, 40)))
        behind = at + 8 + length
        at = behind + length % 2
        if length % 2 and not _is_name(_chunk(file, at)[0]) and _is_name(_chunk(file, behind)[0]):
            at, is_unpadded = behind, True
    return None


def _repair(
    file: BinaryIO, form: tuple[int, int, str], start: int, length: int, size: int, *, is_unpadded: bool
) -> WavRepair | None:
    """What is wrong with the size of the samples, if anything."""
    channels, rate_hz, subtype = form
    block = channels * _BYTES[subtype]
    there = max(0, size - start)
    rest = there - length - length % 2
    if length == 0 and _are_chunks(file, start, size):
        return None
    if length in OPEN_SIZES and there >= block:
        sentence = "its header was not finished: the samples were read to the end of the file"
    elif length > there:
        sentence = f"it breaks off: its header promises {length / block / rate_hz:.2f} s of sound"
    elif rest >= REST_MIN_S * rate_hz * block and not _are_chunks(file, start + length + length % 2, size):
        sentence = (
            f"its header names only {length / block / rate_hz:.2f} s: the samples were read to the end of the file"
        )
    elif is_unpadded:
        sentence, there = "a chunk of its header lacks its padding byte", length
    else:
        return None
    return WavRepair(start, start + there // block * block, channels, rate_hz, subtype, sentence)


_BYTES = {"PCM_U8": 1, "PCM_16": 2, "PCM_24": 3, "PCM_32": 4, "FLOAT": 4, "DOUBLE": 8}


def _form(content: bytes) -> tuple[int, int, str] | None:
    """Channels, rate and form of the samples; None for a form that is left to the library."""
    if len(content) < 16:
        return None
    tag, channels, rate_hz, _, _, bits = struct.unpack("<HHIIHH", content[:16])
    if tag == _EXTENSIBLE and len(content) >= 26:
        (tag,) = struct.unpack("<H", content[24:26])
    subtype = _SUBTYPES.get((tag, bits))
    is_possible = 0 < channels <= CHANNELS_MAX and 0 < rate_hz <= RATE_MAX_HZ
    return (channels, rate_hz, subtype) if subtype and is_possible else None


def _are_chunks(file: BinaryIO, at: int, size: int) -> bool:
    """Whether the rest of the file is chunks, or nothing."""
    for _ in range(CHUNKS_MAX):
        if at + 8 > size:
            return True
        name, length = _chunk(file, at)
        if not _is_name(name) or at + 8 + length > size + 1:
            return False
        at += 8 + length + length % 2
    return False


def _chunk(file: BinaryIO, at: int) -> tuple[bytes, int]:
    """Name and size of a chunk; an empty name behind the end of the file. The file stands behind them."""
    file.seek(at)
    head = file.read(8)
    return (head[:4], struct.unpack("<I", head[4:])[0]) if len(head) == 8 else (b"", 0)


def _is_name(name: bytes) -> bool:
    return len(name) == 4 and all(32 <= character < 127 for character in name)
