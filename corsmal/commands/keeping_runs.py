"""``runs rename``, ``note``, ``archive``, ``restore`` and ``compare``: runs as people keep them."""

from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import Root, say, show
from corsmal.commands.runs import Name, open_run
from corsmal.errors import NotFoundError


def rename(root: Root, name: Name, new: Annotated[str, typer.Argument(metavar="NEW", help="Its new name.")]) -> None:
    """Rename a run. What was computed from it, and links to it, stay."""
    from corsmal import runs
    from corsmal.store import Store

    _, run = open_run(root, name)
    say(f"Run: {runs.label_run(run, store=Store(), name=new).name}")


def note(
    root: Root, name: Name, text: Annotated[str, typer.Argument(metavar="TEXT", help="The note; empty: none.")]
) -> None:
    """Write a note on a run."""
    from corsmal import runs
    from corsmal.store import Store

    _, run = open_run(root, name)
    runs.label_run(run, store=Store(), note=text)


def archive(
    root: Root, name: Name, *, undo: Annotated[bool, typer.Option("--undo", help="Take it out again.")] = False
) -> None:
    """Put a run into the archive: the app lists it only on request."""
    from corsmal import runs
    from corsmal.store import Store

    _, run = open_run(root, name)
    runs.label_run(run, store=Store(), is_archived=not undo)


def restore(root: Root, name: Name) -> None:
    """Bring a deleted run back, within 30 days."""
    from corsmal import runs
    from corsmal.dataset import open_dataset
    from corsmal.store import Store

    store, folder = Store(), str(open_dataset(root).root)
    deleted = [each.run for each in runs.deleted_runs(store=store, dataset=folder)]
    found = next((run for run in deleted if run.name == name), None)
    if found is None:
        names = ", ".join(run.name for run in deleted) or "none"
        raise NotFoundError(f"there is no deleted run {name!r} on {folder}; deleted runs: {names}")
    say(f"Run: {runs.restore_run(found, store=store).name}")


def compare(
    root: Root, names: Annotated[list[str], typer.Argument(metavar="NAME NAME …", help="Names of two or more runs.")]
) -> None:
    """Show what runs were made with, where it differs."""
    from corsmal.runs.differences import parameter_differences

    found = [open_run(Path(root), name)[1] for name in names]
    table = parameter_differences(found)
    if table.empty:
        say("They have the same parameters, networks and recordings.")
        return
    show("What the runs were made with, where it differs", table.rename(columns={run.id: run.name for run in found}))
