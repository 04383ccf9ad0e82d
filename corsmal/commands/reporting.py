"""``report``: a run as one HTML file."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import Root, Without, complain, progress_bar, say
from corsmal.commands.runs import Name, open_run
from corsmal.errors import CorsmalError, NotFoundError

if TYPE_CHECKING:
    from corsmal.dataset import Dataset
    from corsmal.figures.pins import Pin


def report(
    root: Root,
    name: Name,
    *,
    out: Annotated[Path, typer.Option(help="HTML file to write.")] = Path("report.html"),
    protocol: Annotated[
        Literal["held-out", "paper", "in-sample"], typer.Option(help="Numbers that count, as in `evaluate estimates`.")
    ] = "held-out",
    without: Without = None,
    against: Annotated[str | None, typer.Option(help="Name of an earlier run to compare with.")] = None,
    pins: Annotated[
        str | None, typer.Option(help="Name of a collection of pins to show, as *Pins* in the app's sidebar has it.")
    ] = None,
    title: Annotated[str, typer.Option(help="Title; default: the names of run and dataset.")] = "",
    author: Annotated[str, typer.Option(help="Who makes the report.")] = "",
) -> None:
    """Write the report of a run: one HTML file that opens and prints without a network.

    Its figures are drawn as pictures by Chrome or Chromium; without one, the reader's browser draws them.
    """
    from corsmal.figures.report import draw_report, report_html
    from corsmal.files import writing
    from corsmal.runs.report import run_report

    dataset, run = open_run(root, name)
    earlier = None if against is None else open_run(root, against)[1]
    shown = [] if pins is None else _pins_of(pins, dataset)
    made = run_report(
        run,
        dataset,
        protocol=protocol,
        without=tuple(without or ()),
        against=earlier,
        pins=shown,
        title=title,
        author=author,
    )
    pictures: list[bytes] = []
    try:
        with progress_bar("figures") as progress:
            pictures = draw_report(made, progress=progress)
    except CorsmalError as error:
        complain("The reader's browser will draw the figures", error)
    with writing(out, advice="choose another file") as part:
        part.write_text(report_html(made, pictures=pictures), encoding="utf-8")
    say(f"Report: {out}, {out.stat().st_size / 1e6:.1f} MB")


def _pins_of(name: str, dataset: "Dataset") -> "list[Pin]":
    """The pins of a collection.

    Raises:
        NotFoundError: it holds none.
    """
    from corsmal.figures.pin_collections import list_collections, load_collection
    from corsmal.store import Store

    store, fingerprint = Store(), dataset.fingerprint
    found = load_collection(name, dataset=fingerprint, store=store).load(store=store)
    if not found:
        names = list_collections(dataset=fingerprint, store=store)
        known = ", ".join(names) or "none"
        raise NotFoundError(f"there is no pin in a collection {name!r} on {dataset.root}; collections: {known}")
    return found
