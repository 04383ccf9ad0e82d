"""The engine of this machine: as many processes as it has cores and memory for."""

import os
import sys
from pathlib import Path

from corsmal.engines.engine import Engine, in_turn
from corsmal.engines.processes import Processes, cores

PROCESS_BYTES = 2_000_000_000
"""Peak memory of a process with a network."""


GPU_DEVICES = ("/dev/nvidiactl", "/dev/kfd", "/dev/dxg")
"""Files of the drivers of NVIDIA's and AMD's GPUs, and of those of a Windows host."""


def local_engine(
    recordings: int,
    *,
    workers: int | None = None,
    detects: bool = False,
    gives_way: bool = False,
    forks: bool = False,
) -> Engine:
    """The engine of this machine for a number of recordings: by default as many processes as cores and memory allow.

    A detector on a GPU is run by one process only. Processes that give way let other programs go first; those that
    ``forks`` asks for begin as copies of this one, see ``Processes``.
    """
    count = min(1 if detects and has_gpu() else workers or default_workers(), recordings)
    return Processes(count, gives_way=gives_way, forks=forks) if count > 1 else in_turn


def default_workers() -> int:
    """As many processes as this machine has cores and free memory for."""
    return max(1, min(cores(), _available_bytes() // PROCESS_BYTES))


def has_gpu() -> bool:
    """Whether PyTorch sees a GPU; where Linux has no driver of one, this is known without loading PyTorch."""
    if sys.platform == "linux" and not any(Path(device).exists() for device in GPU_DEVICES):
        return False
    import torch  # noqa: PLC0415 - takes seconds

    return torch.cuda.is_available()


def _available_bytes() -> int:
    """Free memory as reported by Linux; elsewhere enough for one process per core."""
    try:
        fields = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines())
        return int(fields["MemAvailable"].split()[0]) * 1024
    except (OSError, ValueError, KeyError):
        return PROCESS_BYTES * (os.cpu_count() or 1)
