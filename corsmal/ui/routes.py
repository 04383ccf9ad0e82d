"""What the server hands out beside the pages: plotly.js and thumbnails. The server starts with it: it loads little."""

import threading
from collections import OrderedDict
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route

from corsmal.digests import digest
from corsmal.errors import CorsmalError
from corsmal.ui.linked_plot import plotly_route

if TYPE_CHECKING:
    from corsmal.dataset import Dataset

DATASETS_MAX = 32

PAGE_PATHS = {
    "overview": "",
    "recordings": "dataset",
    "frames": "best-frame",
    "shape": "hull",
    "filling": "sound",
    "mass": "weight",
    "evaluation": "results",
}
"""Under a page's own name whoever types it is sent on to its address: Streamlit takes a page with the address of its
file for its older kind of app, whose pages run without ``app.py``."""

_datasets: "OrderedDict[str, Dataset]" = OrderedDict()
_lock = threading.Lock()


def routes() -> list[Route]:
    """The routes to give to ``st.App``."""
    named = [Route(f"/{name}", _page) for name in PAGE_PATHS]
    return [plotly_route(), Route("/thumbnails/{dataset}/{recording}.jpg", _thumbnail), *named]


def thumbnail_urls(dataset: "Dataset", ids: list[str]) -> list[str]:
    """Addresses of recordings' thumbnails; only datasets that a page has shown are served."""
    name = digest("dataset", str(dataset.root))
    with _lock:
        _datasets[name] = dataset
        _datasets.move_to_end(name)
        while len(_datasets) > DATASETS_MAX:
            _datasets.popitem(last=False)
    return [f"/thumbnails/{name}/{recording}.jpg" for recording in ids]


def _page(request: Request) -> Response:
    path, query = PAGE_PATHS[request.url.path.rpartition("/")[2]], request.url.query
    return RedirectResponse(f"./{path}" + (f"?{query}" if query else ""))  # relative: the app may have a base path


def _thumbnail(request: Request) -> Response:
    from corsmal.store import Store  # noqa: PLC0415 - see the top of the file
    from corsmal.ui import media  # noqa: PLC0415

    dataset = _datasets.get(request.path_params["dataset"])
    if dataset is None:
        return PlainTextResponse("no such dataset is open", status_code=404)
    try:
        content = media.thumbnail(dataset[request.path_params["recording"]], store=Store())
    except CorsmalError:
        return PlainTextResponse("no picture", status_code=404)
    return Response(content, media_type="image/jpeg", headers={"Cache-Control": "private, max-age=3600"})
