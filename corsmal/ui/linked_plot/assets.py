"""The files that the browser needs: the component's own, and plotly.min.js out of the installed plotly package."""

import importlib.metadata
from pathlib import Path
from typing import Final

from starlette.requests import Request
from starlette.responses import FileResponse
from starlette.routing import Route

from corsmal.ui.base_path import with_base

HERE: Final = Path(__file__).parent

_PATH: Final = f"/corsmal/plotly-{importlib.metadata.version('plotly')}.min.js"


def plotly_url() -> str:
    """Where the app serves plotly.js; the version is in the name so that browsers may keep the file for good."""
    return with_base(_PATH)


def plotly_route() -> Route:
    """The route that serves plotly.js from this machine, to be given to ``st.App(routes=...)``."""
    return Route(plotly_url(), _plotly_js)


def read_asset(name: str, *, folder: Path = HERE) -> str:
    """The text of a file that lies beside this one, or in the folder of another component."""
    return (folder / name).read_text(encoding="utf-8")


async def _plotly_js(_request: Request) -> FileResponse:
    import plotly  # noqa: PLC0415 - the server starts without it

    return FileResponse(
        Path(plotly.__file__).parent / "package_data" / "plotly.min.js",
        media_type="text/javascript",
        headers={"Cache-Control": "public, max-age=31536000, immutable"},
    )
