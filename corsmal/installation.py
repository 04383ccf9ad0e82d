"""Where the program's own files are: in a checkout of the repository, or installed as a package."""

from pathlib import Path
from typing import Final

PACKAGE: Final = Path(__file__).resolve().parent

EXTRA_OF: Final = {
    "streamlit": "app",
    "plotly": "app",
    "kaleido": "app",
    "lightning": "train",
    "tensorboard": "train",
    "distributed": "dask",
    "rerun": "exchange",
    "onnxruntime": "exchange",
}
"""What only some of the library needs, and the extra that installs it."""


def checkout() -> Path | None:
    """The repository's folder, if the library is used from there; None where it is installed."""
    folder = PACKAGE.parent
    return folder if (folder / "pyproject.toml").is_file() and (folder / "app.py").is_file() else None


def app_script() -> Path:
    """The script that Streamlit runs: ``app.py`` of the checkout, or the copy in the installed package."""
    return (checkout() or PACKAGE / "app") / "app.py"


def default_cache() -> Path:
    """The folder for results where ``CORSMAL_CACHE`` names none: ``cache`` of the checkout, or the user's cache."""
    from platformdirs import user_cache_path  # noqa: PLC0415 - a checkout does not need it

    folder = checkout()
    return user_cache_path("corsmal", appauthor=False) if folder is None else folder / "cache"


def missing_extra(error: ModuleNotFoundError) -> str | None:
    """What to install, if a module is missing that an extra brings; None for any other module."""
    module = (error.name or "").partition(".")[0]
    extra = EXTRA_OF.get(module)
    return extra and f"this needs {module}, which is not installed: pip install 'corsmal[{extra}]'"
