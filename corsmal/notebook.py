"""Records as small tables in a notebook: what their ``_repr_html_`` returns."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape

PICTURE_PX = 150


def record_html(title: str, facts: Mapping[str, str], *, notes: Iterable[str] = (), picture: str = "") -> str:
    """A table of facts with a title.

    Args:
        title: what the record is.
        facts: texts by name; empty ones are left out.
        notes: sentences that stand below.
        picture: SVG that stands beside it, such as ``outline_svg``.
    """
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th><td style='text-align:left'>{escape(text)}</td></tr>"
        for name, text in facts.items()
        if text
    )
    below = "".join(f"<li>{escape(note)}</li>" for note in notes)
    table = f"<div><b>{escape(title)}</b><table>{rows}</table>{f'<ul>{below}</ul>' if below else ''}</div>"
    return f"<div style='display:flex;gap:1.5em;align-items:center'>{picture}{table}</div>" if picture else table


def outline_svg(heights_mm: Sequence[float], radii_mm: Sequence[float]) -> str:
    """A solid of revolution from the side, as SVG; empty for fewer than two circumferences.

    Args:
        heights_mm: heights, ascending, mm.
        radii_mm: as many radii, mm.
    """
    if len(heights_mm) < 2:
        return ""
    top, widest = max(heights_mm), max(radii_mm)
    right = [(radius, top - height) for height, radius in zip(heights_mm, radii_mm, strict=True)]
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in [*right, *((-x, y) for x, y in reversed(right))])
    box = f"{-widest - 2:.1f} -2 {2 * widest + 4:.1f} {top - min(heights_mm) + 4:.1f}"
    return (
        f"<svg viewBox='{box}' width='{PICTURE_PX}' height='{PICTURE_PX}' role='img' aria-label='outline'>"
        f"<polygon points='{points}' fill='#0f766e' fill-opacity='0.25' stroke='#0f766e' stroke-width='1'/></svg>"
    )
