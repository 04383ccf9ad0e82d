"""A real server and two visitors at once, who talk to it as browsers do."""

import signal
import socket
from pathlib import Path

import pytest

from corsmal.ui.linked_plot.assets import plotly_url
from tests.benchmarks.sessions import memory_mb, served
from tests.benchmarks.visit import Visit

GRACE_S = 20
"""Five seconds on a machine that does nothing else."""


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def test_two_visitors_step_through_their_own_frames_and_the_server_ends_when_it_is_told(
    sound_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CORSMAL_DATA", str(sound_root))
    with served(free_port(), str(tmp_path / "served")) as (address, server):
        with Visit(address, "best-frame") as first, Visit(address, "best-frame") as second:
            for visitor in (first, second):
                visitor.open("recording=000000")
            for frame in (1, 2):
                first.report("time_line", values={"frame": frame}, settled=True)
                second.report("time_line", values={"frame": frame + 3}, settled=True)
                assert first.components["time_line"]["frame"] == frame
                assert second.components["time_line"]["frame"] == frame + 3
            line = first.components["time_line"]
            assert first.fetch(f"{line['url']}view1/2.jpg") > 0
            assert first.errors + first.problems + second.errors + second.problems == []
        assert memory_mb(server.pid)[0] > 50
    assert server.returncode in (0, -signal.SIGTERM)


def test_a_visitor_who_does_not_read_what_he_asked_for_does_not_keep_the_server(tmp_path: Path) -> None:
    port = free_port()
    with served(port, str(tmp_path / "served")) as (_address, server), socket.socket() as visitor:
        visitor.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        visitor.connect(("127.0.0.1", port))
        visitor.sendall(f"GET {plotly_url()} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode())
        assert visitor.recv(16).startswith(b"HTTP/1.1 200")
        server.send_signal(signal.SIGTERM)
        server.wait(timeout=GRACE_S)
