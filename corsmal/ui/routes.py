"""What the server hands out beside the pages: plotly.js, thumbnails, what the time line plays; and what browsers say.

The server starts with it: it loads little.
"""

import secrets
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Generic, TypeVar

from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route

from corsmal.digests import digest
from corsmal.errors import CorsmalError
from corsmal.ui.base_path import with_base
from corsmal.ui.linked_plot import plotly_route

if TYPE_CHECKING:
    from corsmal.dataset import Dataset
    from corsmal.ui.playback import Playback

DATASETS_MAX, PLAYBACKS_MAX, DRAWINGS_MAX = 32, 8, 64
FOR_AN_HOUR = {"Cache-Control": "private, max-age=3600"}

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

Item = TypeVar("Item")


class Shown(Generic[Item]):
    """What pages have shown, by name: nothing else is served. The oldest is forgotten where there are too many."""

    def __init__(self, at_most: int) -> None:
        self._at_most = at_most
        self._items: OrderedDict[str, Item] = OrderedDict()
        self._lock = threading.Lock()

    def put(self, name: str, item: Item) -> None:
        """Serve an item under a name, instead of an earlier one of that name."""
        with self._lock:
            self._items[name] = item
            self._items.move_to_end(name)
            while len(self._items) > self._at_most:
                self._items.popitem(last=False)

    def get(self, name: str) -> Item | None:
        """The item of a name."""
        with self._lock:
            return self._items.get(name)


_datasets: "Shown[Dataset]" = Shown(DATASETS_MAX)
_playbacks: "Shown[Playback]" = Shown(PLAYBACKS_MAX)
_drawings: Shown[Mapping[str, threading.Event]] = Shown(DRAWINGS_MAX)


def routes() -> list[Route]:
    """The routes to give to ``st.App``, below the server's base path."""
    named = [Route(with_base(f"/{name}"), _page) for name in PAGE_PATHS]
    return [
        plotly_route(),
        Route(with_base("/thumbnails/{dataset}/{recording}.jpg"), _thumbnail),
        Route(with_base("/playback/{playback}/sound/{channel:int}.wav"), _sound),
        Route(with_base("/playback/{playback}/original/{view}/{frame:int}.jpg"), _original),
        Route(with_base("/playback/{playback}/{view}/{frame:int}.jpg"), _picture),
        Route(with_base("/drawn/{drawing}/{part}"), _drawn, methods=["POST"]),
        *named,
    ]


def thumbnail_urls(dataset: "Dataset", ids: list[str]) -> list[str]:
    """Addresses of recordings' thumbnails; only datasets that a page has shown are served."""
    name = digest("dataset", str(dataset.root))
    _datasets.put(name, dataset)
    return [with_base(f"/thumbnails/{name}/{recording}.jpg") for recording in ids]


def playback_url(playback: "Playback", key: object) -> str:
    """The address under which a recording is played.

    ``VIEW/FRAME.jpg``, ``original/VIEW/FRAME.jpg`` without detections, and ``sound/CHANNEL.wav`` follow it.

    Args:
        playback: the recording; it takes the place of an earlier one of the same key.
        key: of the recording's files, and of whatever else tells two playbacks apart that are shown at the same time.
    """
    name = digest("playback", key)
    _playbacks.put(name, playback)
    return with_base(f"/playback/{name}/")


def drawn_url(parts: Mapping[str, threading.Event]) -> str:
    """The address under which a browser says what it has drawn: the name of a part follows it.

    Args:
        parts: what is set when the browser says so, by name.
    """
    name = secrets.token_urlsafe(12)
    _drawings.put(name, parts)
    return with_base(f"/drawn/{name}")


def _page(request: Request) -> Response:
    path, query = PAGE_PATHS[request.url.path.rpartition("/")[2]], request.url.query
    return RedirectResponse(f"./{path}" + (f"?{query}" if query else ""))  # relative: the app may have a base path


def _drawn(request: Request) -> Response:
    drawn = (_drawings.get(request.path_params["drawing"]) or {}).get(request.path_params["part"])
    if drawn is not None:
        drawn.set()
    return Response(status_code=204)


def _thumbnail(request: Request) -> Response:
    from corsmal.store import Store  # noqa: PLC0415 - see the top of the file
    from corsmal.ui import media  # noqa: PLC0415

    name, recording = request.path_params["dataset"], request.path_params["recording"]
    return _reply(_datasets.get(name), lambda dataset: media.thumbnail(dataset[recording], store=Store()), "image/jpeg")


def _picture(request: Request) -> Response:
    view, frame = request.path_params["view"], request.path_params["frame"]
    playback = _playbacks.get(request.path_params["playback"])
    return _reply(playback, lambda playback: playback.picture(view, frame), "image/jpeg")


def _original(request: Request) -> Response:
    view, frame = request.path_params["view"], request.path_params["frame"]
    playback = _playbacks.get(request.path_params["playback"])
    return _reply(playback, lambda playback: playback.original(view, frame), "image/jpeg")


def _sound(request: Request) -> Response:
    from corsmal.dataset.audio import CHANNELS  # noqa: PLC0415 - see the top of the file

    number = request.path_params["channel"]  # as people count them; 0: the mean of all
    playback = _playbacks.get(request.path_params["playback"]) if number <= CHANNELS else None
    return _reply(playback, lambda playback: playback.sound(number - 1 if number else None), "audio/wav")


def _reply(item: Item | None, read: Callable[[Item], bytes], media_type: str) -> Response:
    """What is read from an item that a page has shown; where there is nothing, that is all that is said."""
    if item is None:
        return PlainTextResponse("not open", status_code=404)
    try:
        content = read(item)
    except CorsmalError:
        return PlainTextResponse("nothing to show", status_code=404)
    return Response(content, media_type=media_type, headers=FOR_AN_HOUR)
