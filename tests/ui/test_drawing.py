"""What a browser says of its drawing: whoever waits for it goes on, and nobody waits twice."""

import time
from threading import Timer

import pytest

from corsmal.ui import drawing
from tests.ui.test_routes import get


@pytest.fixture(autouse=True)
def session(monkeypatch):
    monkeypatch.setattr(drawing.st, "session_state", {})


def say(path, **options):
    return get(path, **({"method": "POST"} | options))


def waited_s(part):
    began_s = time.monotonic()
    drawing.let_draw(part)
    return time.monotonic() - began_s


def test_the_wait_ends_when_the_browser_says_so(monkeypatch):
    monkeypatch.setattr(drawing, "AT_MOST_S", {"numbers": 60.0, "rest": 0.02})
    url = drawing.begin()
    Timer(0.05, lambda: say(f"{url}/numbers")).start()
    assert 0.04 < waited_s("numbers") < 50
    assert 0.01 < waited_s("rest") < 50  # said by nobody


def test_a_session_asks_and_waits_once(monkeypatch):
    monkeypatch.setattr(drawing, "AT_MOST_S", {"numbers": 0.02, "rest": 60.0})
    assert waited_s("rest") < 50  # nobody was asked
    assert drawing.begin() is not None
    assert drawing.begin() is None
    drawing.let_draw("numbers")
    monkeypatch.setattr(drawing, "AT_MOST_S", {"numbers": 60.0, "rest": 60.0})
    assert waited_s("numbers") < 50


def test_what_nobody_waits_for_is_taken_and_nothing_is_said():
    url = drawing.begin()
    for path in (f"{url}/other", "/drawn/unknown/numbers"):
        status, _, body = say(path)
        assert (status, body) == (204, b"")
    assert say(f"{url}/numbers", method="GET")[0] == 405
    state = drawing.st.session_state[drawing.DRAWING]
    assert not state.numbers.is_set()
    assert not state.rest.is_set()
