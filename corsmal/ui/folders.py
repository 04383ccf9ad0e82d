"""Which folders this server opens, and whether visitors may change anything; light, for it is asked before all else."""

import argparse
import os
import sys
from pathlib import Path

from streamlit import config

from corsmal.demo import opening
from corsmal.errors import CorsmalError
from corsmal.store import Store

REFUSED = "This server opens only the datasets in its own data folder: name one of them, such as train."
READ_ONLY = "This server is read-only: it shows what is there, and visitors cannot start, change or delete anything."

LOOPBACK = ("127.0.0.1", "::1", "localhost")
"""Addresses that only this machine reaches; a server without an address listens on all."""


class RefusedError(CorsmalError):
    """A visitor asked for what this server was started not to do."""


def demo_folder() -> Path:
    """Where the ready-made demo is, or is to be."""
    return opening.demo_folder(Store())


def full_demo_folder() -> Path:
    """Where the full demo is, or is to be."""
    return opening.full_demo_folder(Store())


def is_demo(folder: str) -> bool:
    """Whether a folder is the ready-made or the full demo's."""
    return Path(folder) in (demo_folder(), full_demo_folder())


def default_folder() -> str:
    """The folder of ``streamlit run app.py -- --data DIR``, else of ``CORSMAL_DATA``, else the demo's."""
    return str(_options().data or demo_folder())


def data_root() -> Path | None:
    """The folder of ``--data-root DIR``, else of ``CORSMAL_DATA_ROOT``: only datasets in it are opened.

    A server without one that others than this machine can reach opens only the folder that it was started with.
    """
    root = _options().data_root or (default_folder() if _is_exposed() else None)
    return Path(root).resolve() if root else None


def is_read_only() -> bool:
    """Whether the server was started with ``--read-only`` or ``CORSMAL_READ_ONLY=1``, for guests."""
    return bool(_options().read_only)


def check_may_change() -> None:
    """Refuse what a visitor of a read-only server must not do.

    Raises:
        RefusedError: the server is read-only.
    """
    if is_read_only():
        raise RefusedError(READ_ONLY)


def allowed_folder(text: str) -> str:
    """The folder that a visitor names, if this server opens it.

    With a data root, names are relative to it, and what a link or ``..`` leads to must lie in it, too. Whatever else is
    named is refused in the same words, whether it exists or not.

    Args:
        text: as typed, or as an address led to it.

    Returns:
        The text itself where no data root is set, else the folder's full path, without links.

    Raises:
        RefusedError: the folder lies elsewhere.
    """
    root = data_root()
    if root is None or is_demo(text) or text == default_folder():
        return text
    try:
        folder = (root / text).resolve()
    except (OSError, RuntimeError, ValueError):  # what can be no path, or links that lead in a circle
        folder = None
    if folder is None or not folder.is_relative_to(root):
        raise RefusedError(REFUSED)
    return str(folder)


def _is_exposed() -> bool:
    """Whether the server listens on more than this machine's own address."""
    address = config.get_option("server.address")
    return address not in LOOPBACK


def _options() -> argparse.Namespace:
    """What stands after ``--`` in ``streamlit run app.py -- …``, or else in the environment."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--data", default=os.environ.get("CORSMAL_DATA"))
    parser.add_argument("--data-root", default=os.environ.get("CORSMAL_DATA_ROOT"))
    is_read_only = os.environ.get("CORSMAL_READ_ONLY", "") not in ("", "0")
    parser.add_argument("--read-only", action="store_true", default=is_read_only)
    return parser.parse_known_args(sys.argv[1:])[0]
