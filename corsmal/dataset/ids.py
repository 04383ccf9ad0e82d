"""The one rule for recording ids, wherever they come from: tables, file names, arguments, addresses."""

import re
from collections.abc import Iterable

import numpy as np

ID_PATTERN = re.compile(r"[0-9A-Za-z_-]{1,100}")
"""What a recording's id may look like: it becomes part of file names."""

DIGITS = 6
"""Numbers are written with at least that many digits, as the published sets write them."""

_NUMBER = re.compile(r"([0-9]+)(?:[.,]0*)?")
_SCIENTIFIC = re.compile(r"[0-9](?:[.,][0-9]{1,15})?[eE]\+[0-9]{1,2}")
"""What spreadsheets make of a number in a narrow column."""

_QUOTED = re.compile(r"=\"([^\"]*)\"|'(.*)")
"""What spreadsheets write around a number that shall keep its zeros."""

_FILE = re.compile(r"(?:.*[/\\])?([^/\\]+)\.(?:mp4|m4v|mov|avi|mkv|webm|wav|flac|pickle|pkl|json|npy)", re.IGNORECASE)


def recording_id(value: object) -> str | None:
    """The id of a recording, or None for what can be none.

    A number has six digits, however it was written: 618, 618.0, ``"618"``, ``"0618"``, ``"618,0"``, ``"6.18E+02"`` and
    ``618.mp4`` are ``"000618"``. Any other id is letters, digits, ``_`` and ``-``, not beginning with ``-``, and stays
    as it is.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, int) and not isinstance(value, bool):
        value = str(value) if 0 <= value < 10**100 else None
    if not isinstance(value, str):
        return None
    text = value.strip()
    if quoted := _QUOTED.fullmatch(text):
        text = (quoted[1] or quoted[2] or "").strip()
    if file := _FILE.fullmatch(text):
        text = file[1].strip()
    if _SCIENTIFIC.fullmatch(text) and (value := float(text.replace(",", "."))).is_integer():
        text = str(int(value))
    if number := _NUMBER.fullmatch(text):
        text = number[1].lstrip("0").zfill(DIGITS)
    return text if ID_PATTERN.fullmatch(text) and not text.startswith("-") else None


def listed(names: Iterable[str]) -> str:
    """Up to three recordings, and how many more."""
    names = list(names)
    shown = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
    return f"recording {shown}" if len(names) == 1 else f"recordings {shown}"
