"""``evaluate estimates`` and ``train wall``: what is done with estimates."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

import typer

from corsmal.commands import MatchViews, Offsets, Root, Without, progress_bar, say, show, view_matching

if TYPE_CHECKING:
    import pandas as pd

    from corsmal.evaluation.challenge import Absent
    from corsmal.evaluation.protocols import Protocol
    from corsmal.evaluation.splits import FoundSplit

Estimates = Annotated[Path, typer.Argument(metavar="TABLE", help="Table written by `estimate`.")]


def estimates(
    root: Root,
    table: Estimates,
    *,
    out: Annotated[Path | None, typer.Option(help="Table 2 as .tex, .csv, .html or .md.")] = None,
    protocol: Annotated[
        list[str] | None,
        typer.Option(
            help="Numbers that count: held-out (default) only those of networks not trained on the recording; "
            "paper also those whose epoch was chosen on it; in-sample all. Repeat it for a column group each."
        ),
    ] = None,
    split: Annotated[
        Literal["train", "public", "private", "other"] | None,
        typer.Option(help="Challenge set that is scored; default: found from the folder's name and annotation."),
    ] = None,
    absent: Annotated[
        Literal["skip", "zero"],
        typer.Option(help="Recordings without a row: skip does not score them, zero is the challenge's rule."),
    ] = "skip",
    without: Without = None,
) -> None:
    """Compare estimates with a dataset's annotation: the paper's Table 2 and the challenge's scores."""
    import pandas as pd

    from corsmal.dataset import open_dataset
    from corsmal.evaluation import ENDINGS, find_split, read_estimates, typeset_table_2
    from corsmal.evaluation.flagged import without_flagged
    from corsmal.evaluation.splits import FoundSplit
    from corsmal.files import writing

    formats = {ending: name for name, ending in ENDINGS.items()}
    if out is not None and out.suffix not in formats:
        raise typer.BadParameter(f"the name must end in {', '.join(formats)}", param_hint="--out")
    dataset, found = open_dataset(root), read_estimates(table)
    found, left_out = without_flagged(found, without or ())
    own = find_split(dataset.table, name=dataset.name)
    scored_as = own if split is None else FoundSplit(split, "--split names it")
    said = [left_out] if left_out else []
    for sentence in said:
        say(sentence)
    judged = [
        _judge(found, dataset.table, protocol=cast("Protocol", name), split=scored_as, absent=absent, said=said)
        for name in dict.fromkeys(protocol or ["held-out"])
    ]
    if out is not None:
        text = typeset_table_2(
            pd.concat(judged),
            table_format=formats[out.suffix],
            notes=said,
            is_like_with_like=own.split == "train",
        )
        with writing(out, advice="choose another file") as part:
            part.write_text(text, encoding="utf-8")


def _judge(
    found: "pd.DataFrame",
    annotation: "pd.DataFrame",
    *,
    protocol: "Protocol",
    split: "FoundSplit",
    absent: "Absent",
    said: list[str],
) -> "pd.DataFrame":
    """Print all that a protocol says about estimates.

    Args:
        found: the estimates.
        annotation: the dataset's table.
        protocol: which numbers count.
        split: what is scored.
        absent: how recordings without a row are scored.
        said: sentences below the tables so far, none of which is repeated; grows.

    Returns:
        Table 2 cell by cell.
    """
    import numpy as np

    from corsmal.evaluation import (
        cell_table,
        challenge_scores,
        comparison_note,
        confusion_tables,
        container_table,
        error_table,
        submission_table,
    )

    errors = error_table(found, annotation, protocol=protocol)
    cells = cell_table(errors, rng=np.random.default_rng(0))
    scores = challenge_scores(annotation, submission_table(found), split=split.split, absent=absent, errors=errors)
    for note in (*errors.attrs["notes"], comparison_note(cells), *scores.attrs["notes"]):
        if note and note not in said:
            say(note)
            said.append(note)
    show(f"By container ({protocol}): MPF1 and MAPE in %", container_table(errors).drop(columns="protocol"))
    counts = cells[cells["container_id"].isna()].set_index("metric")[["recordings", "failures", "left_out"]]
    show(f"Recordings behind the averages ({protocol})", counts)
    for quantity in ("filling_level", "filling_type"):
        for kind, table in confusion_tables(errors, quantity).items():
            if table.to_numpy().sum():
                show(f"{quantity.replace('_', ' ')}, {kind} ({protocol}): rows are true, columns estimated", table)
    scored = f"{scores.attrs['scored']} of {len(annotation)} recordings"
    show(f"The challenge's scores in % ({protocol}), {scored}\n{split}", scores.rename("score").to_frame())
    return cells


def wall(root: Root, *, match: MatchViews = None, offset: Offsets = None) -> None:
    """Learn the wall thickness that the preset tuned subtracts from round containers, from annotated capacities."""
    from corsmal.dataset import open_dataset
    from corsmal.runs.wall import learn_wall
    from corsmal.store import Store

    recordings = list(open_dataset(root).matched(view_matching(match, offset)))
    with progress_bar("recordings") as progress:
        learned = learn_wall(recordings, store=Store(), progress=progress)
    names = {"no_wall_pct": "no wall", "preset_pct": "preset", "others_pct": "others", "wall_mm": "others, mm"}
    show(
        "Mean capacity error in % by container: without a wall, with the preset's, with that of the other containers",
        learned.table.set_index("container").rename(columns=names),
    )
    say(f"Wall: {learned.wall_mm:.1f} mm. To use it: estimate --preset tuned --wall {learned.wall_mm:.1f}")
