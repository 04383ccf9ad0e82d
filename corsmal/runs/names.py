"""What a run may be called."""

import re
from collections.abc import Iterable, Iterator
from itertools import count

from corsmal.errors import ArgumentError

NAME_MAX = 60
SIGNS = ". , + = ( ) % ° -"
"""What a name may have besides letters, digits, ``_`` and spaces: nothing that Markdown, HTML, LaTeX, a path or a
spreadsheet's formula needs."""


def check_name(name: str, *, taken: Iterable[str]) -> str:
    """A new name of a run, without the spaces around it.

    Args:
        name: what was typed.
        taken: the names of the other runs on the dataset.

    Raises:
        ArgumentError: it is empty, too long, taken, or has other signs than letters, digits, spaces and a few more.
    """
    name = name.strip()
    if not name:
        raise ArgumentError(f"a run needs a name of 1 to {NAME_MAX} characters")
    if len(name) > NAME_MAX:
        raise ArgumentError(f"a run's name has at most {NAME_MAX} characters, got {len(name)}")
    if not re.fullmatch(rf"[^\W_][\w {re.escape(SIGNS)}]*", name):
        raise ArgumentError(
            f"a run's name begins with a letter or digit and holds letters, digits, spaces and _ {SIGNS} only, "
            f"got {name!r}"
        )
    if name in taken:
        raise ArgumentError(f"the name {name!r} is taken by another run on this dataset; choose another one")
    return name


def numbered_names(base: str) -> Iterator[str]:
    """A name, then the same with 2, 3 and so on behind it."""
    yield base
    yield from (f"{base[: NAME_MAX - 1 - len(str(number))]} {number}" for number in count(2))
