"""``python -m corsmal.demo FOLDER``: make the ready-made demo anew; FOLDER is a new one, for intermediate results."""

import sys
from pathlib import Path

from corsmal.demo.packing import make_pack

if __name__ == "__main__":
    make_pack(Path(sys.argv[1]), say=lambda step: sys.stderr.write(f"{step}\n"))
