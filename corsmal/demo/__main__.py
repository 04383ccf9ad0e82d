"""``python -m corsmal.demo FOLDER``: make the ready-made demo anew."""

import argparse
import sys
from pathlib import Path

from corsmal.demo.packing import make_pack

if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m corsmal.demo", description="Make the ready-made demo anew.")
    parser.add_argument("folder", type=Path, help="a new folder, for intermediate results")
    make_pack(parser.parse_args().folder, say=lambda step: sys.stderr.write(f"{step}\n"))
