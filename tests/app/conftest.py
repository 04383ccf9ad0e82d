"""Every test of the app has its own store, nothing cached, and an app that was started without a dataset.

The full demo that such an app makes has one small recording.
"""

import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import pytest
import streamlit as st

from corsmal import synthetic
from corsmal.detection import ViewDetections
from corsmal.stages.inspection import InProcess, Piece
from corsmal.stages.settings import DetectorSettings
from corsmal.synthetic.writing.dataset import write_demo
from corsmal.ui import shared
from tests.tiny import write_tiny_dataset


@pytest.fixture(autouse=True)
def fresh_app(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("CORSMAL_DATA", raising=False)
    monkeypatch.setattr(sys, "argv", ["app.py"])
    monkeypatch.setattr(synthetic, "write_demo", small_demo)
    monkeypatch.setattr(shared, "inspector", cache(InspectorHere))
    _clear_caches()
    yield
    _end_jobs()
    _clear_caches()


class InspectorHere:
    """A detector in this process, where a test may have put another one in its place; how fast it is, tests say."""

    piece_frames = 4
    frame_s: float | None = None

    def __init__(self, settings: DetectorSettings) -> None:
        self._settings = settings

    @cached_property
    def _inspector(self) -> InProcess:
        return InProcess(self._settings.open())

    @property
    def digest(self) -> str:
        return self._inspector.digest

    def __call__(
        self, pieces: Sequence[Piece], *, cancelled: Callable[[], bool]
    ) -> Iterator[tuple[int, ViewDetections]]:
        yield from self._inspector(pieces, cancelled=cancelled)


def small_demo(root: Path, **options: Any) -> tuple[str, ...]:
    """The full demo with one small recording, made in this process."""
    small = {"containers": (1,), "recordings_per_container": 1, "size": (160, 90), "workers": 0}
    return write_demo(root, **options | small)


@pytest.fixture(scope="session")
def sound_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One recording of six frames with nothing wrong; read only."""
    return write_tiny_dataset(tmp_path_factory.mktemp("sound") / "train", recordings=1, frames=6)


@pytest.fixture(scope="session")
def shared_store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("store")


@pytest.fixture
def real_root(real_dataset_root: Path, shared_store: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The real recording; its tests share a store, because copying four videos for the browser takes seconds."""
    monkeypatch.setenv("CORSMAL_CACHE", str(shared_store))
    return real_dataset_root


@pytest.fixture
def root(sound_root: Path, tmp_path: Path) -> Path:
    """A copy of the sound dataset, to be damaged."""
    return Path(shutil.copytree(sound_root, tmp_path / "train"))


def _end_jobs() -> None:
    """Background work must not go on into the next test."""
    deadline = time.monotonic() + 60
    for job in list(shared.jobs()._jobs.values()):
        job.cancel()
        while job.active:
            assert time.monotonic() < deadline, f"{job.label} does not end"
            time.sleep(0.01)


def _clear_caches() -> None:
    shared.jobs.cache_clear()
    shared.store.cache_clear()
    st.cache_data.clear()
    st.cache_resource.clear()
