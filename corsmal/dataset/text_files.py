"""Text files of other programs, in whichever encoding they were written."""

import codecs
from dataclasses import dataclass
from pathlib import Path

from corsmal.errors import FileError

_MARKS = (
    (codecs.BOM_UTF8, "utf-8", "UTF-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le", "UTF-32"),
    (codecs.BOM_UTF32_BE, "utf-32-be", "UTF-32"),
    (codecs.BOM_UTF16_LE, "utf-16-le", "UTF-16"),
    (codecs.BOM_UTF16_BE, "utf-16-be", "UTF-16"),
)
"""Byte order marks; those of UTF-32 begin with those of UTF-16."""

_OTHERS = (
    (b"PK\x03\x04", "is a spreadsheet or another archive and no text; open it and save it as CSV"),
    (b"\xd0\xcf\x11\xe0", "is a spreadsheet and no text; open it and save it as CSV"),
    (b"%PDF", "is a PDF and no table; save the table as CSV"),
    (b"\x1f\x8b", "is compressed; unpack it"),
    (b"version https://git-lfs", "is only a pointer to a file that Git LFS holds; fetch the file itself"),
)
"""How files begin that are often named like tables, and what to do about them."""

_PAGES = (b"<!doctype html", b"<html")


@dataclass(frozen=True)
class Text:
    """A file's text.

    Args:
        content: the text without a byte order mark.
        note: which encoding was assumed, where it is not UTF-8; else empty.
    """

    content: str
    note: str = ""


def read_text(path: Path) -> Text:
    """Read a text file: UTF-8, UTF-16 or UTF-32, with or without a byte order mark, or else Windows-1252.

    Raises:
        FileError: the file cannot be read, or holds no text; the text says what it seems to be.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror or error})") from error
    for start, problem in _OTHERS:
        if content.startswith(start):
            raise FileError(path, problem)
    if content[:200].lstrip().lower().startswith(_PAGES):
        raise FileError(path, "is a web page and no table; download the file itself")
    encoding, name, skipped = _encoding(path, content)
    try:
        text = content[skipped:].decode(encoding)
    except UnicodeDecodeError as error:
        raise FileError(path, f"begins as {name} text and cannot be read as such; save it as UTF-8") from error
    if "\0" in text:
        raise FileError(path, "holds zero bytes, so it is no text; save the table as CSV in UTF-8")
    return Text(text, "" if name == "UTF-8" else f"it is read as {name}")


def _encoding(path: Path, content: bytes) -> tuple[str, str, int]:
    """The encoding's name for Python and for people, and the length of the byte order mark."""
    for mark, encoding, name in _MARKS:
        if content.startswith(mark):
            return encoding, name, len(mark)
    if b"\0" in content:
        even, odd = content[::2].count(0), content[1::2].count(0)
        # of plain letters in UTF-16 every other byte is zero
        if max(even, odd) < len(content) // 3 or min(even, odd) > max(even, odd) // 10:
            raise FileError(path, "holds zero bytes, so it is no text; save the table as CSV in UTF-8")
        return ("utf-16-le" if odd > even else "utf-16-be"), "UTF-16", 0
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        return ("latin-1" if any(byte in content for byte in b"\x81\x8d\x8f\x90\x9d") else "cp1252"), "Windows-1252", 0
    return "utf-8", "UTF-8", 0
