import asyncio
from pathlib import Path

import cv2
import numpy as np
import plotly
import pytest
from starlette.applications import Starlette
from streamlit.web.server.app_discovery import discover_asgi_app

from corsmal.dataset import open_dataset
from corsmal.ui import base_path
from corsmal.ui.linked_plot.assets import plotly_url
from corsmal.ui.playback import Playback
from corsmal.ui.routes import DATASETS_MAX, PAGE_PATHS, PLAYBACKS_MAX, playback_url, routes, thumbnail_urls
from tests.tiny import FRAMES, write_tiny_dataset

APP = Path(__file__).resolve().parents[2] / "app.py"


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)


def get(path, *, query=b"", method="GET"):
    """Ask the routes as a server would: status, headers and body."""
    sent = []

    async def receive():
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message):
        sent.append(message)

    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "query_string": query,
        "headers": [],
        "http_version": "1.1",
    }
    scope["asgi"] = {"version": "3.0", "spec_version": "2.4"}  # below 2.4 a reply waits for the browser to hang up
    asyncio.run(Starlette(routes=routes())(scope, receive, send))
    headers = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
    return sent[0]["status"], headers, b"".join(message.get("body", b"") for message in sent[1:])


def test_thumbnails_of_a_dataset_that_a_page_showed_are_served(dataset):
    urls = thumbnail_urls(dataset, ["000000", "000001"])
    assert len(set(urls)) == 2
    for url in urls:
        status, headers, body = get(url)
        assert (status, headers["content-type"]) == (200, "image/jpeg")
        assert cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_COLOR).shape[1] == 160


@pytest.mark.parametrize("name", ["000099", "..", "..%2f..%2fetc%2fpasswd", "000000.exe", " ", "%00"])
def test_a_recording_that_is_not_there_is_not_found(dataset, name):
    [url] = thumbnail_urls(dataset, ["000000"])
    status, _, body = get(url.replace("000000", name))
    assert status == 404
    assert b"/" not in body


def test_a_dataset_that_no_page_showed_is_not_served(dataset):
    [url] = thumbnail_urls(dataset, ["000000"])
    assert get(url.replace(url.split("/")[2], "0" * 32))[0] == 404


def test_a_recording_whose_video_is_broken_has_no_picture(tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=2)
    (root / "view3" / "rgb" / "000000.mp4").write_bytes(b"no video")
    [url] = thumbnail_urls(open_dataset(root), ["000000"])
    status, _, body = get(url)
    assert (status, body) == (404, b"nothing to show")


def test_datasets_that_were_not_shown_for_long_are_forgotten(dataset, tmp_path):
    root = write_tiny_dataset(tmp_path / "first", recordings=1, frames=2)
    [first] = thumbnail_urls(open_dataset(root), ["000000"])
    for number in range(DATASETS_MAX - 1):
        other = tmp_path / f"set{number}"
        (other / "audio").mkdir(parents=True)
        (other / "audio" / "000001.wav").touch()
        thumbnail_urls(open_dataset(other), ["000001"])
    assert get(first)[0] == 200
    thumbnail_urls(dataset, ["000000"])
    assert get(first)[0] == 404


@pytest.fixture
def url(dataset):
    """Where a recording of which one view lacks is played."""
    recording = dataset["000001"]
    videos = {name: recording.views[name].video() for name in ("view1", "view3")}
    return playback_url(Playback(recording, videos, {}, "none"), "a test's")


def test_pictures_of_a_recording_that_a_page_showed_are_served(url):
    pictures = set()
    for view in ("view1", "view3"):
        for frame in (0, FRAMES - 1):
            status, headers, body = get(f"{url}{view}/{frame}.jpg")
            assert (status, headers["content-type"]) == (200, "image/jpeg")
            assert cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_COLOR).shape == (360, 640, 3)
            pictures.add(body)
    assert len(pictures) == 4


@pytest.mark.parametrize(
    "path",
    [
        *(f"view1/{frame}.jpg" for frame in (FRAMES, -1, "x", 10**30)),
        *(f"sound/{channel}.wav" for channel in (0, 9, -1)),
        "view2/0.jpg",
        "../0.jpg",
    ],
)
def test_a_picture_or_sound_that_is_not_there_is_not_found(url, path):
    assert get(url + path)[0] == 404


def test_a_recording_that_no_page_showed_is_not_played(url):
    assert get(url.replace(url.split("/")[2], "0" * 32) + "view1/0.jpg")[0] == 404


def test_recordings_that_were_not_shown_for_long_are_not_played_any_more(url, dataset):
    for number in range(PLAYBACKS_MAX - 1):
        playback_url(Playback(dataset["000001"], {}, {}, "none"), number)
    assert get(f"{url}view1/0.jpg")[0] == 200
    playback_url(Playback(dataset["000001"], {}, {}, "none"), "one more")
    assert get(f"{url}view1/0.jpg")[0] == 404


def test_plotly_comes_from_this_machine():
    status, headers, body = get(f"/corsmal/plotly-{plotly.__version__}.min.js")
    assert (status, headers["content-type"].split(";")[0]) == (200, "text/javascript")
    assert len(body) > 1_000_000


def test_streamlit_finds_the_application_with_its_routes() -> None:
    assert discover_asgi_app(Path(__file__).resolve().parents[2] / "app.py").is_asgi_app


@pytest.mark.parametrize("name", PAGE_PATHS)
def test_a_pages_name_leads_to_its_address_with_all_that_it_says(name):
    status, headers, _ = get(f"/{name}", query=b"recording=000618&frame=3")
    assert status == 307
    assert headers["location"] == f"./{PAGE_PATHS[name]}?recording=000618&frame=3"
    assert get(f"/{name}")[1]["location"] == f"./{PAGE_PATHS[name]}"


@pytest.mark.parametrize("written", ["/group/corsmal/", "corsmal", "a/b/c", "/lab-1/cups", "Übung/v1.0"])
def test_everything_lies_below_the_servers_base_path(dataset, monkeypatch, written):
    monkeypatch.setattr(base_path.config, "get_option", {"server.baseUrlPath": written}.get)
    base = "/" + written.strip("/")
    [url] = thumbnail_urls(dataset, ["000000"])
    assert url.startswith(f"{base}/thumbnails/")
    assert get(url)[0] == 200
    assert get(f"{base}/shape", query=b"frame=3")[1]["location"] == "./hull?frame=3"
    assert get(plotly_url())[0] == 200
    assert get("/shape")[0] == 404


def test_every_page_has_an_address_under_its_name():
    assert set(PAGE_PATHS) == {path.stem for path in (APP.parent / "pages").glob("*.py")}
    assert all(f'"{path}"' in APP.read_text() for path in PAGE_PATHS.values() if path)
