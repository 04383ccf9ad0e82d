"""Which dataset folder the app begins with, and where the built-in demo is; light, for it is asked before all else."""

import argparse
import os
import sys
from pathlib import Path

from corsmal.demo import opening
from corsmal.store import Store


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
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--data", default=os.environ.get("CORSMAL_DATA"))
    return str(parser.parse_known_args(sys.argv[1:])[0].data or demo_folder())
