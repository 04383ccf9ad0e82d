"""Which dataset folder the app begins with, and where the built-in demo is; light, for it is asked before all else."""

import argparse
import os
import sys
from pathlib import Path

from corsmal.store import Store
from corsmal.synthetic import ANNOTATION_FILE


def demo_folder() -> Path:
    """Where the demo is, or is to be."""
    return Store().root.resolve() / "demo"


def is_demo(folder: str) -> bool:
    """Whether a folder is the built-in demo's."""
    return Path(folder) == demo_folder()


def is_demo_ready() -> bool:
    """Whether the demo has a first recording."""
    return (demo_folder() / ANNOTATION_FILE).is_file()


def default_folder() -> str:
    """The folder of ``streamlit run app.py -- --data DIR``, else of ``CORSMAL_DATA``, else the demo's."""
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--data", default=os.environ.get("CORSMAL_DATA"))
    return str(parser.parse_known_args(sys.argv[1:])[0].data or demo_folder())
