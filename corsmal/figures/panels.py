"""Panels one below the other on one time axis: where they lie, their captions, and what more than one figure draws."""

from collections.abc import Mapping

from corsmal.figures.sound import SoundPicture, band_of
from corsmal.figures.style import TRUTH, Part, axis, note, scatter

CAPTION_PX = 22
TICKS_HZ = {200: "0.2", 1000: "1", 3000: "3", 10000: "10"}
TITLE = {"font": {"size": 11}, "standoff": 4}
TICKS = {"fixedrange": True, "tickfont": {"size": 11}, "ticklabelstandoff": 6}


def stacked_domains(heights_px: Mapping[str, int], *, lane_px: int = 0) -> tuple[int, dict[str, list[float]]]:
    """Where panels lie, from above, each below its caption.

    Args:
        heights_px: of the panels.
        lane_px: kept free above all.

    Returns:
        The plot's height in pixels, and the share of it that each panel takes, from below.
    """
    inner_px = lane_px + sum(height + CAPTION_PX for height in heights_px.values())
    domains, top_px = {}, inner_px - lane_px
    for name, height in heights_px.items():
        top_px -= CAPTION_PX
        domains[name] = [(top_px - height) / inner_px, top_px / inner_px]
        top_px -= height
    return inner_px, domains


def panel_axis(yaxis: Part, domain: list[float]) -> Part:
    """The vertical axis of a panel, in small type."""
    return yaxis | {"domain": domain} | TICKS | {"title": yaxis["title"] | TITLE}


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
