"""Captions of pins: what a pin shows, of what, with which numbers and parameters, and what was noted."""

import html
from collections.abc import Mapping

from corsmal.evaluation.exporting import MISSING
from corsmal.figures.pins import Pin


def escaped(text: object) -> str:
    """Text as HTML, within an attribute too."""
    return html.escape(str(text), quote=True)


def pin_caption(pin: Pin) -> str:
    """All that a pin's record says, as HTML."""
    places = {"dataset": pin.dataset, "recording": pin.recording, "frame": pin.frame, "run": pin.run}
    where = ", ".join(f"{name} {value}" for name, value in places.items() if value is not None)
    with_what = "; ".join(f"{name}: {value}" for name, value in pin.parameters.items())
    parts = [
        f"<b>{escaped(pin.title)}</b>",
        f'<p class="note">{escaped(pin.note)}</p>' if pin.note else "",
        _numbers(pin.numbers),
        f"<p>{escaped(where[:1].upper() + where[1:])}.</p>" if where else "",
        f"<p>Parameters: {escaped(with_what)}.</p>" if with_what else "",
        f"<p>Address in the app: <code>{escaped(pin.link)}</code></p>" if pin.link else "",
    ]
    return "".join(parts)


def _numbers(numbers: Mapping[str, str]) -> str:
    """Numbers in a line; those of several sources, such as ``Capacity, frame 25, tuned``, as a table of them."""
    split = {name: name.partition(", ") for name in numbers}
    sources = list(dict.fromkeys(source for _, _, source in split.values()))
    quantities = list(dict.fromkeys(quantity for quantity, _, _ in split.values()))
    if len(sources) < 2 or len(quantities) < 2 or "" in sources:
        shown = "".join(f"<li>{escaped(name)} <b>{escaped(value)}</b></li>" for name, value in numbers.items())
        return f'<ul class="numbers">{shown}</ul>' if shown else ""
    by_place = {split[name][::2]: value for name, value in numbers.items()}
    heads = "".join(f"<th>{escaped(source)}</th>" for source in sources)
    rows = "".join(
        f"<tr><th>{escaped(quantity)}</th>"
        + "".join(f"<td>{escaped(by_place.get((quantity, source), MISSING))}</td>" for source in sources)
        + "</tr>"
        for quantity in quantities
    )
    return f'<table class="numbers"><thead><tr><th></th>{heads}</tr></thead><tbody>{rows}</tbody></table>'
