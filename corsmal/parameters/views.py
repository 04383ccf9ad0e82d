"""The cameras' views, the pairs of them that are fitted, and what counts as a container."""

from collections.abc import Sequence

from corsmal.errors import ArgumentError

CONTAINER_CLASSES = {44: "bottle", 46: "wine glass", 47: "cup", 84: "book", 86: "vase"}
"""COCO category numbers of the objects that are taken for a container (paper 3.1)."""

Pair = tuple[str, str]

PAIRS: tuple[Pair, ...] = (("view3", "view1"), ("view3", "view2"))
"""The pairs of views in the order in which the paper tries them: its (1, 2) and (1, 3), in the dataset's names."""

RELEASED_PAIRS: tuple[Pair, ...] = (("view1", "view2"), ("view1", "view3"))
"""The pairs of views in the order in which the authors' program tries them."""

METHOD_VIEWS = tuple(dict.fromkeys(view for pair in PAIRS for view in pair))
"""The views that the method uses, in the order of the paper's pairs."""

FRONTAL_VIEW = PAIRS[0][0]
"""The robot's own view, from which the container's mass is predicted."""


def check_pairs(pairs: Sequence[Pair]) -> None:
    """Check pairs of views.

    Raises:
        ArgumentError: there is none, one does not hold two different views of the method, or two hold the same views.
    """
    if not pairs:
        raise ArgumentError("pairs must hold at least one pair of views, got none")
    for pair in pairs:
        if len(pair) != 2 or pair[0] == pair[1] or not set(pair) <= set(METHOD_VIEWS):
            raise ArgumentError(f"pairs must each be two of {', '.join(sorted(METHOD_VIEWS))}, got {'-'.join(pair)!r}")
    if len({frozenset(pair) for pair in pairs}) < len(pairs):
        raise ArgumentError(f"pairs must differ, got {', '.join('-'.join(pair) for pair in pairs)}")


def read_pair(text: str) -> Pair:
    """A pair of views as it is typed, such as ``view3-view1``.

    Raises:
        ArgumentError: it is no such pair.
    """
    first, _, second = text.strip().partition("-")
    check_pairs([(first, second)])
    return first, second


def all_pairs(pairs: Sequence[Pair]) -> tuple[Pair, ...]:
    """Every pair of views once: these, in their order and spelling, then those that are left."""
    views = sorted(METHOD_VIEWS)
    others = [(first, second) for index, first in enumerate(views) for second in views[index + 1 :]]
    known = {frozenset(pair) for pair in pairs}
    return (*pairs, *(pair for pair in others if frozenset(pair) not in known))
