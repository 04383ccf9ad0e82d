"""A visitor of a running server, who talks to it as a browser does: through Streamlit's WebSocket."""

import json
import time
import urllib.request
from contextlib import ExitStack
from types import TracebackType
from typing import Any, Self

from streamlit.proto.BackMsg_pb2 import BackMsg
from streamlit.proto.ForwardMsg_pb2 import ForwardMsg
from streamlit.proto.WidgetStates_pb2 import WidgetState
from websockets.sync.client import connect

TIMEOUT_S = 120.0


class Visit:
    """One session.

    Args:
        address: of the server, such as ``http://127.0.0.1:8501``.
        page: its path, such as ``hull``; empty: the first one.
    """

    def __init__(self, address: str, page: str = "") -> None:
        self.address, self._page, self._hash, self._query = address, page, "", ""
        self._ends = ExitStack()
        self._socket = self._ends.enter_context(
            connect(
                f"{address.replace('http', 'ws', 1)}/_stcore/stream",
                subprotocols=["streamlit"],  # type: ignore[list-item]
                max_size=None,
                compression=None,
                open_timeout=TIMEOUT_S,
            )
        )
        self._widgets: dict[str, WidgetState] = {}
        self._reports: dict[str, int] = {}
        self.components: dict[str, dict[str, Any]] = {}
        self._ids: dict[str, tuple[str, str]] = {}
        self.errors: list[str] = []
        self.problems: list[str] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ends.close()

    def open(self, query: str = "") -> float:
        """Open the page, or step to another address of it; returns how long that took, s.

        Args:
            query: what the address has behind its question mark.
        """
        self._query = query
        return self._run(is_step=True)

    def report(self, component: str, **report: Any) -> float:
        """Say what a user did in a component of the page; returns how long the answer took, s."""
        name, fragment = self._ids[component]
        self._reports[component] = self._reports.get(component, 0) + 1
        state = {"report": {"sequence": self._reports[component], **report}}
        self._widgets[name] = WidgetState(id=name, json_value=json.dumps(state))
        took_s = self._run(fragment)
        if self.components[component]["acknowledged"] != self._reports[component]:
            self.errors.append(f"the page did not take over what was done in {component}")
        return took_s

    def choose(self, key: str, value: str) -> float:
        """Choose an option of a control with several that lie side by side."""
        name, fragment = self._ids[key]
        state = WidgetState(id=name)
        state.string_array_value.data.append(value)
        self._widgets[name] = state
        return self._run(fragment)

    def press(self, key: str) -> float | None:
        """Press a button; None where the page has none of that key."""
        if key not in self._ids:
            return None
        name, fragment = self._ids[key]
        return self._run(fragment, pressed=WidgetState(id=name, trigger_value=True))

    def fetch(self, path: str) -> float:
        """Fetch a picture or sound of the server; returns how long that took, s."""
        began_s = time.monotonic()
        with urllib.request.urlopen(f"{self.address}{path}", timeout=TIMEOUT_S) as answer:
            answer.read()
        return time.monotonic() - began_s

    def _run(self, fragment: str = "", *, pressed: WidgetState | None = None, is_step: bool = False) -> float:
        message = BackMsg()
        state = message.rerun_script
        state.page_script_hash, state.fragment_id = self._hash, fragment
        state.page_name = "" if self._hash else self._page
        state.query_string, state.is_history_navigation = self._query, is_step and bool(self._hash)
        state.widget_states.widgets.extend([*self._widgets.values(), *([] if pressed is None else [pressed])])
        began_s = time.monotonic()
        self._socket.send(message.SerializeToString())
        while True:
            left_s = TIMEOUT_S - (time.monotonic() - began_s)
            answer = ForwardMsg.FromString(self._socket.recv(timeout=max(0.0, left_s)))  # type: ignore[arg-type]
            kind = answer.WhichOneof("type")
            if kind == "delta":
                self._note(answer)
            elif kind == "navigation":
                self._hash = answer.navigation.page_script_hash
            elif kind == "page_not_found":
                self.errors.append(f"there is no page {self._page}")
            elif kind == "script_finished" and answer.script_finished != ForwardMsg.FINISHED_EARLY_FOR_RERUN:
                if answer.script_finished == ForwardMsg.FINISHED_WITH_COMPILE_ERROR:
                    self.errors.append("the script could not be compiled")
                return time.monotonic() - began_s

    def _note(self, answer: ForwardMsg) -> None:
        element = answer.delta.new_element
        kind = element.WhichOneof("type")
        if kind == "exception":
            self.errors.append(f"{element.exception.type}: {element.exception.message}")
        elif kind == "alert" and element.alert.format == element.alert.ERROR:
            self.problems.append(element.alert.body)
        content = getattr(element, kind) if kind else None
        name = getattr(content, "id", "")
        if name.count("-") >= 2:
            key = name.split("-", 2)[2]
            self._ids[key] = name, answer.delta.fragment_id
            if kind == "bidi_component" and content is not None and content.WhichOneof("data") == "json":
                self.components[key] = json.loads(content.json)
