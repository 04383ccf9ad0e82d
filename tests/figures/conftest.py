"""Whatever a test draws, what goes to the browser unchecked is what Plotly makes of it where it checks it."""

import base64
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest

from corsmal.figures.drawing import Drawing


@pytest.fixture(autouse=True)
def parts_are_the_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = Drawing.__call__

    def checked(self: Drawing[Any], *args: Any, **options: Any) -> go.Figure:
        figure = plain(self, *args, **options)
        expected = figure.to_plotly_json()
        expected["layout"].pop("template", None)
        assert_same(self.parts(*args, **options), expected)
        return figure

    monkeypatch.setattr(Drawing, "__call__", checked)


def assert_same(found: Any, expected: Any, at: str = "figure") -> None:
    if isinstance(expected, dict) and "bdata" in expected:
        numbers = np.frombuffer(base64.b64decode(expected["bdata"]), expected["dtype"])
        np.testing.assert_array_equal(np.ravel(found), numbers, at)
    elif isinstance(expected, dict):
        found, expected = (
            {name: part for name, part in each.items() if not is_empty(part)} for each in (found, expected)
        )
        assert found.keys() == expected.keys(), at
        for name, part in expected.items():
            assert_same(found[name], part, f"{at}.{name}")
    elif isinstance(expected, list | tuple) and any(isinstance(part, dict) for part in expected):
        assert len(found) == len(expected), at
        for number, part in enumerate(expected):
            assert_same(found[number], part, f"{at}[{number}]")
    elif isinstance(expected, list | tuple | np.ndarray):
        assert list(found) == list(expected), at
    else:
        assert found == expected, at


def is_empty(part: Any) -> bool:
    """Plotly leaves out some of what is empty."""
    return part is None or (isinstance(part, list | tuple) and not part)
