"""The challenge's sets, and which of them a dataset is."""

import re
from dataclasses import dataclass
from typing import Literal, get_args

import pandas as pd

from corsmal.evaluation.checking import truth_table

Split = Literal["train", "public", "private", "other"]
SPLITS: tuple[Split, ...] = get_args(Split)
SPLIT_NAMES: dict[Split, str] = {
    "train": "the challenge's training set",
    "public": "the challenge's public test set",
    "private": "the challenge's private test set",
    "other": "a set that is none of the challenge's",
}

TRAINING_SET = dict.fromkeys(range(1, 7), 84) | dict.fromkeys(range(7, 10), 60)
"""Recordings of the training set by container id."""

TEST_RECORDINGS = 228
"""Of the public test set, and of the private one."""


@dataclass(frozen=True)
class FoundSplit:
    """Which of the challenge's sets a dataset is scored as.

    Args:
        split: the set.
        reason: why, as the rest of a sentence.
    """

    split: Split
    reason: str

    def __str__(self) -> str:
        return f"Scored as {SPLIT_NAMES[self.split]}, because {self.reason}."


def find_split(annotation: pd.DataFrame, *, name: str) -> FoundSplit:
    """Which of the challenge's sets a dataset is.

    Args:
        annotation: a dataset's table, or the columns of the annotation file.
        name: of the dataset's folder.

    Returns:
        ``train`` for the training set's number of annotated recordings of each of containers 1 to 9, whatever the
        folder's name; ``public`` or ``private`` for 228 recordings in a folder named so, such as ``test_pub``; else
        ``other``.

    Raises:
        ArgumentError: the annotation is no table, or has no rows or ids.
    """
    containers = truth_table(annotation)["container_id"]
    training = sum(TRAINING_SET.values())
    if containers.value_counts().to_dict() == TRAINING_SET:
        return FoundSplit("train", f"it has the training set's {training} annotated recordings of containers 1 to 9")
    named: tuple[Split, ...] = ("public", "private")
    for split in named:
        if re.search(rf"(?<![a-z])({split}|{split[:3]})(?![a-z])", name.lower()):
            found = f"the folder is named {name!r} and has {len(containers)} recordings"
            if len(containers) == TEST_RECORDINGS:
                return FoundSplit(split, found)
            return FoundSplit("other", f"{found}, but {SPLIT_NAMES[split]} has {TEST_RECORDINGS}")
    return FoundSplit(
        "other",
        f"it is neither the training set ({training} annotated recordings of containers 1 to 9; here {len(containers)} "
        f"recordings) nor named after a test set (test_pub, test_pri)",
    )
