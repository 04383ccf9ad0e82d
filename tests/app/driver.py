"""Plays one visitor of the app: opens pages, does what a browser would report, and reads what it would show."""

import base64
import json
import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from streamlit.runtime.scriptrunner_utils.script_requests import RerunData
from streamlit.testing.v1 import AppTest, local_script_runner
from streamlit.util import calc_hash

from corsmal.quantities import BY_NAME, GEOMETRY
from corsmal.ui.messages import WORD_JOINER
from corsmal.ui.overview.tiles import KEYS

APP = Path(__file__).resolve().parents[2] / "app.py"
PAGES = {
    name: f"pages/{name}.py" for name in ("overview", "recordings", "frames", "shape", "filling", "mass", "evaluation")
}
PATHS = {"recordings": "dataset", "overview": ""}
"""Under which addresses a visit may begin."""
TIMEOUT_S = 60


class Visitor:
    """A session of the app.

    Args:
        folder: what the visitor types as the dataset folder; None: what the app was started with, or else the demo.
        begins: the page that is opened: ``recordings`` computes least.
        address: query parameters of the address that is opened.
    """

    def __init__(self, folder: object = None, *, begins: str = "recordings", **address: str) -> None:
        self.test = AppTest.from_file(str(APP), default_timeout=TIMEOUT_S)
        self.test._page_hash = calc_hash(PATHS[begins])  # `switch_page` needs a page that has run
        if folder is not None:
            self.test.session_state["data_folder"] = str(folder)
        self._sequences: dict[str, int] = {}
        for name, value in address.items():
            self.test.query_params[name] = value
        self.test.run()

    def open(self, page: str) -> "Visitor":
        """Go to a page by the navigation, which empties the address."""
        self.test.switch_page(PAGES[page])
        self.test.query_params.clear()
        self.test.run()
        return self

    def go_back(self, **address: str) -> None:
        """Step to another address of the same page, as the browser's Back does."""
        with patch("corsmal.ui.session._stepped_in_history", return_value=True):
            self.run_at(**address)

    def run_at(self, **address: str) -> None:
        """Let the app run for a browser that has another address."""
        self.test.query_params.clear()
        for name, value in address.items():
            self.test.query_params[name] = value
        self.test.run()

    def report(self, plot: str, **report: Any) -> None:
        """What the browser says that the user did to a linked plot."""
        self._sequences[plot] = self._sequences.get(plot, 0) + 1
        self.test.session_state[plot] = {"report": {"sequence": self._sequences[plot], **report}}
        self.test.run()

    def drag(self, plot: str, **values: float) -> None:
        """Drag sliders of a linked plot: only the part of the page runs that holds it, as in a browser."""
        *_, part = self.test._fragment_storage._fragments  # the first one is the tray of pins
        with patch.object(local_script_runner, "RerunData", partial(RerunData, fragment_id=part)):
            self.report(plot, values=values, settled=False)

    def select_row(self, row: int) -> None:
        """Tick the box of a row of the recordings' table."""
        key = self.test.dataframe[0].proto.id.split("-", 2)[2]
        self.test.session_state[key] = {"selection": {"rows": [row], "columns": [], "cells": []}}
        self.test.run()

    def choose(self, key: str, value: object) -> None:
        """Set a widget."""
        self.widget(key).set_value(value).run()

    def widget(self, key: str) -> Any:
        """A widget of the page by its key, which may have a number behind it."""
        keys = re.compile(rf"{re.escape(key)}(\.\d+)?")
        return next(item for item in self.test.main if keys.fullmatch(getattr(item, "key", None) or ""))

    def press(self, label: str) -> None:
        """Press a button, or the link of a number of the *Overview*."""
        if label in self.tiles:
            self.report(self._tiles_key, opens=label)
            return
        next(button for button in self.test.button if button.label == label).click().run()

    def wait_for(self, condition: Callable[["Visitor"], object]) -> None:
        """Run the app again, as a page does that watches a job, until something holds."""
        deadline = time.monotonic() + TIMEOUT_S
        while not condition(self):
            assert time.monotonic() < deadline, self.sentences
            time.sleep(0.05)
            self.test.run()

    @property
    def link(self) -> dict[str, str]:
        """The query parameters that the app wrote."""
        params = self.test.query_params.items()
        return {name: value if isinstance(value, str) else value[-1] for name, value in params}

    @property
    def address(self) -> dict[str, str]:
        """What the address says of the dataset that is open."""
        return {name: value for name, value in self.link.items() if name != "dataset"}

    @property
    def crashes(self) -> list[str]:
        return [element.value for element in self.test.exception]

    @property
    def warnings(self) -> list[str]:
        return [seen(element.value) for element in self.test.warning]

    @property
    def errors(self) -> list[str]:
        return [seen(element.value) for element in self.test.error]

    @property
    def sentences(self) -> str:
        """Everything that the page says about problems and what to do, a line each."""
        kinds = (self.test.error, self.test.warning, self.test.info, self.test.caption)
        return "\n".join(seen(element.value) for kind in kinds for element in kind)

    @property
    def progress(self) -> list[str]:
        """The texts of the progress bars."""
        bars: list[Any] = list(self.test.get("progress"))
        return [seen(bar.proto.text) for bar in bars]

    @property
    def metrics(self) -> dict[str, str]:
        """The page's measures by label."""
        tiles = {label: str(tile["value"]) for label, tile in self.tiles.items()}
        return tiles | {metric.label: metric.value for metric in self.test.metric}

    @property
    def tiles(self) -> dict[str, dict[str, Any]]:
        """What was sent to the browser for the numbers of the *Overview*, by label; empty on other pages."""
        return {tile["label"]: tile for tile in self._components.get(self._tiles_key, {}).get("tiles", ())}

    @property
    def _tiles_key(self) -> str:
        return next((key for key in self._components if key in KEYS), "")

    @property
    def frame_measures(self) -> dict[str, str]:
        """The *Shape* page's measures of the shown frame by label, without the compared ones."""
        texts = [caption.value for caption in self.test.caption if "this frame" in caption.value]
        found = [re.findall(r"this frame, `.*?`: \*\*(.*?)\*\*", text)[0] for text in texts]
        return dict(zip((BY_NAME[name].label for name in GEOMETRY), found, strict=False))

    @property
    def plots(self) -> dict[str, dict[str, Any]]:
        """What was sent to the browser for each linked plot, by key; ``figure`` is decoded."""
        sent = {}
        for key, content in self._components.items():
            if "figure" in content:
                sent[key] = content | {"figure": _decoded(json.loads(content["figure"]))}
        return sent

    @property
    def time_line(self) -> dict[str, Any]:
        """What was sent to the browser for the time line; empty where there is none."""
        return self._components.get("time_line", {})

    @property
    def _components(self) -> dict[str, dict[str, Any]]:
        components: list[Any] = list(self.test.get("bidi_component"))
        return {str(component.key): json.loads(component.proto.json) for component in components}

    @property
    def frame(self) -> int:
        """Where the playhead of the time line stands."""
        return int(self.time_line["frame"])

    def go_to(self, frame: int) -> None:
        """Move the playhead, and let it rest."""
        self.report("time_line", values={"frame": frame}, settled=True)

    @property
    def buttons(self) -> list[str]:
        return [button.label for button in self.test.button]

    def count(self, *kinds: str) -> int:
        """How many elements of these kinds, such as ``video``, the page shows."""
        return sum(len(self.test.get(kind)) for kind in kinds)

    def look(self) -> "Seen":
        """What there is to read on the page."""
        return Seen(
            title=self.test.title[0].value,
            crashes=self.crashes,
            errors=self.errors,
            warnings=self.warnings,
            sentences=self.sentences,
            metrics=self.metrics,
            plots=frozenset(self.plots),
            buttons=self.buttons,
            videos=self.count("video"),
            sounds=self.count("audio"),
            pictures=self.count("image", "imgs") + sum(view["frames"] > 0 for view in self.time_line.get("views", ())),
        )


@dataclass(frozen=True)
class Seen:
    """What one page showed."""

    title: str
    crashes: list[str]
    errors: list[str]
    warnings: list[str]
    sentences: str
    metrics: dict[str, str]
    plots: frozenset[str]
    buttons: list[str]
    videos: int
    sounds: int
    pictures: int


def seen(markdown: str) -> str:
    """What a browser shows of a sentence in which some characters stand for themselves."""
    return re.sub(r"\\([^a-zA-Z0-9\s])", r"\1", markdown).replace(WORD_JOINER, "")


def rings(plot: dict[str, Any]) -> int:
    """How many circumferences a hull's figure draws: each ends in a gap."""
    names = ("circumferences", "rejected by d_max", "lower and upper end")
    traces = [trace for trace in plot["figure"]["data"] if trace.get("name") in names]
    return sum(int(np.isnan(trace["x"]).sum()) for trace in traces)


def amount(text: str) -> float:
    """The number that a measure begins with."""
    return float(text.split(maxsplit=1)[0].replace(",", "").replace("−", "-"))


def _decoded(value: Any) -> Any:
    """Plotly's JSON with its packed arrays as NumPy arrays."""
    if isinstance(value, dict):
        if "bdata" in value:
            return np.frombuffer(base64.b64decode(value["bdata"]), dtype=value["dtype"])
        return {key: _decoded(item) for key, item in value.items()}
    return [_decoded(item) for item in value] if isinstance(value, list) else value
