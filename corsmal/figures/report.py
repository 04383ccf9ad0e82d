"""A report in one HTML file: tables, figures that can be turned, pictures, sounds and the parameters behind them."""

import base64
import html
from collections.abc import Mapping, Sequence

import pandas as pd
import plotly.graph_objects as go
import plotly.io
import plotly.offline

from corsmal.figures.pins import Pin

_STYLE = """
:root { color-scheme: light dark; --line: #8884; --soft: #8881; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1080px; margin: 2rem auto; padding: 0 1rem; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.2rem; border-bottom: 1px solid var(--line); }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem; text-align: right; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; } tbody tr:hover { background: var(--soft); }
figure { margin: 1.2rem 0; } figcaption { color: #888; } img { max-width: 100%; } audio { width: 100%; }
"""


def report_html(
    title: str,
    *,
    tables: Mapping[str, pd.DataFrame],
    pins: Sequence[Pin] = (),
    parameters: Mapping[str, object],
    digits: int = 1,
    banner: str = "",
) -> str:
    """A page that opens without a network: everything is in it, plotly.js once, and nothing is sent anywhere.

    Args:
        title: of the report.
        tables: by heading; numbers are rounded.
        pins: in their order.
        parameters: by name, what the numbers were computed with.
        digits: after the decimal point, of the tables' fractions.
        banner: a sentence below the title that no reader may miss, such as what the numbers may be used for.
    """
    parts = [f"<h1>{html.escape(title)}</h1>", f"<p><strong>{html.escape(banner)}</strong></p>" if banner else ""]
    for heading, table in tables.items():
        parts.append(f"<h2>{html.escape(heading)}</h2><div class='scroll'>{_table(table, digits)}</div>")
    if pins:
        parts.append("<h2>Pinned views</h2>")
    parts += [
        f"<figure>{_pinned(pin, number)}<figcaption>{html.escape(pin.title)}</figcaption></figure>"
        for number, pin in enumerate(pins)
    ]
    settings = pd.DataFrame({"parameter": list(parameters), "value": [str(value) for value in parameters.values()]})
    parts.append(f"<h2>Parameters</h2><div class='scroll'>{_table(settings, digits)}</div>")
    has_figures = any(pin.figure is not None for pin in pins)
    script = f"<script>{plotly.offline.get_plotlyjs()}</script>" if has_figures else ""
    head = f"<meta charset='utf-8'><title>{html.escape(title)}</title><style>{_STYLE}</style>{script}"
    return f"<!doctype html><html lang='en'><head>{head}</head><body>{''.join(parts)}</body></html>"


def _table(table: pd.DataFrame, digits: int) -> str:
    return table.to_html(index=False, border=0, na_rep="–", float_format=f"{{:.{digits}f}}".format, justify="unset")


def _pinned(pin: Pin, number: int) -> str:
    if pin.figure is not None:
        # a theme's own transparent paper would leave dark text on a dark page
        figure = go.Figure(pin.figure).update_layout(paper_bgcolor="white", plot_bgcolor="white", height=520)
        config = {"showSendToCloud": False, "displaylogo": False, "responsive": True}
        return str(
            plotly.io.to_html(figure, include_plotlyjs=False, full_html=False, config=config, div_id=f"figure{number}")
        )
    address = f"data:{pin.medium};base64,{base64.b64encode(pin.content).decode()}"
    if pin.medium == "audio/wav":
        return f"<audio controls src='{address}'></audio>"
    return f"<img alt='{html.escape(pin.title, quote=True)}' src='{address}'>"
