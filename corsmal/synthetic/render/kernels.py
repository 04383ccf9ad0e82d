"""How the demo's inner loops are compiled, and the types that they share."""

import os
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])
Vector = tuple[float, float, float]
Pixel = tuple[int, int]
"""Row and column."""


def kernel(function: Function) -> Function:
    """Compile a function on its first call.

    Compiled code is kept on disk only where ``NUMBA_CACHE_DIR`` is set: Numba looks at a kernel's own file to tell
    whether it is out of date, not at those of the kernels that it calls, so that a folder must not outlive a change of
    the sources.
    """
    is_kept = bool(os.environ.get("NUMBA_CACHE_DIR"))
    return cast(Function, njit(cache=is_kept, error_model="numpy")(function))
