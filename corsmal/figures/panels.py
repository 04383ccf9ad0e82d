"""Panels one below the other on one time axis: where they lie, their captions, and what more than one figure draws."""

from collections.abc import Mapping, Sequence
from typing import Any

from corsmal.figures.sound import SoundPicture, band_of
from corsmal.figures.style import TRUTH, Part, axis, note, plain_layout, scatter

CAPTION_PX = 22
TICKS_HZ = {200: "0.2", 1000: "1", 3000: "3", 10000: "10"}
TITLE = {"font": {"size": 11}, "standoff": 4}
TICKS = {"fixedrange": True, "tickfont": {"size": 11}, "ticklabelstandoff": 6}


class Panels:
    """Panels one below the other on one time axis, each below its caption.

    Args:
        heights_px: of the panels, from above.
        lane_px: kept free above all.

    Attributes:
        inner_px: the plot's height in pixels.
        domains: the share of it that each panel takes, from below.
        ids: the vertical axis of each panel, as traces name it.
    """

    def __init__(self, heights_px: Mapping[str, int], *, lane_px: int = 0) -> None:
        self.inner_px = lane_px + sum(height + CAPTION_PX for height in heights_px.values())
        self.domains, top_px = dict[str, list[float]](), self.inner_px - lane_px
        for name, height in heights_px.items():
            top_px -= CAPTION_PX
            self.domains[name] = [(top_px - height) / self.inner_px, top_px / self.inner_px]
            top_px -= height
        self.ids = {name: f"y{number}" if number > 1 else "y" for number, name in enumerate(heights_px, 1)}

    def height_px(self, margin_px: Mapping[str, int]) -> int:
        """Of the figure, with its margins."""
        return self.inner_px + margin_px["t"] + margin_px["b"]

    def layout(
        self,
        *,
        margin_px: Mapping[str, int],
        limits_s: Sequence[float],
        captions: Mapping[str, str],
        axes: Mapping[str, Part],
        annotations: Sequence[Part] = (),
        **more: Any,
    ) -> Part:
        """The figure's layout.

        Args:
            margin_px: around the plot, Plotly's ``l``, ``r``, ``t``, ``b``.
            limits_s: of the time axis.
            captions: of the panels, by name.
            axes: vertical axes of the panels, by name.
            annotations: beside the captions.
            more: as Plotly has it.
        """
        lowest = list(self.ids.values())[-1]
        layout = plain_layout(
            height=self.height_px(margin_px),
            margin=dict(margin_px),
            showlegend=False,
            hovermode="x unified",
            hoversubplots="axis",
            xaxis=axis("time (s)", range=list(limits_s), anchor=lowest, showgrid=False, zeroline=False),
            annotations=[*(caption(captions[name], top) for name, (_, top) in self.domains.items()), *annotations],
            **more,
        )
        for name, domain in self.domains.items():
            yaxis = axes[name]
            title = {"title": yaxis["title"] | TITLE}
            layout[f"yaxis{self.ids[name][1:]}"] = yaxis | {"domain": domain} | TICKS | title
        return layout


def log_mel_axis(picture: SoundPicture) -> Part:
    """Frequencies of the log-mel bands, kHz."""
    shown = {hz: text for hz, text in TICKS_HZ.items() if hz < picture.highest_hz}
    places = [band_of(hz, bands=picture.bands, highest_hz=picture.highest_hz) for hz in shown]
    limits = [-0.5, picture.bands - 0.5]
    return axis("kHz", range=limits, tickvals=places, ticktext=list(shown.values()), showgrid=False, zeroline=False)


def log_mel_image(picture: SoundPicture, *, yaxis: str) -> Part:
    """The log-mel rows as an image that spans a panel."""
    start_s, end_s = picture.span_s
    place = {"x": start_s, "sizex": end_s - start_s, "y": picture.bands - 0.5, "sizey": picture.bands}
    return {"source": picture.log_mel, "xref": "x", "yref": yaxis, "sizing": "stretch", "layer": "below", **place}


def log_mel_caption(picture: SoundPicture) -> str:
    """Whose rows are drawn, and what their colours stand for."""
    low, high = (f"{limit:.0f}".replace("-", "−") for limit in picture.limits)
    text = f"<b>Log-mel</b> by {picture.source}: {picture.unit} power, dark {low} to bright {high}"
    return text + ("; grey: silence" if picture.has_silence else "")


def anchor(yaxis: str) -> Part:
    """Plotly draws no axis that has an image but no trace."""
    return scatter([0], [0], mode="markers", yaxis=yaxis, opacity=0, hoverinfo="skip")


def cursor_text(time_s: float, text: str, *, colour: str = TRUTH) -> Part:
    """The name of a moment, above all panels."""
    return note(text, x=time_s, y=1, yref="paper", yanchor="bottom", font={"size": 11, "color": colour})


def caption(text: str, top: float) -> Part:
    """What a panel shows, above its upper end."""
    place = {"xref": "x domain", "x": 0, "xanchor": "left", "xshift": 8, "yref": "paper", "y": top}
    return note(text, yanchor="bottom", font={"size": 12}, **place)
