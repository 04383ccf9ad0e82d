"""Results that all sessions of a server share. What is cached is never changed by whoever gets it."""

from collections.abc import Callable
from functools import partial, wraps
from typing import Any, ParamSpec, TypeVar

import streamlit as st

P = ParamSpec("P")
Result = TypeVar("Result")


def by_key(subject: Any, *others: object, **options: object) -> tuple[object, ...]:
    """The first argument's ``key``, and the other arguments."""
    return subject.key, others, options


def cached(
    max_entries: int, *, key: Callable[..., object] = by_key, spinner: str | bool = False
) -> Callable[[Callable[P, Result]], Callable[P, Result]]:
    """Compute a function's result once for all sessions of this server, until newer ones take its place.

    Streamlit would hash the arguments themselves, recordings and arrays included.

    Args:
        max_entries: how many results are held.
        key: of the arguments, what the result depends on: text, numbers, tuples and parameters.
        spinner: what the page says meanwhile.
    """

    def decorate(function: Callable[P, Result]) -> Callable[P, Result]:
        def compute(key_text: str, _call: Callable[[], Result]) -> Result:
            del key_text
            return _call()

        compute.__module__, compute.__qualname__ = function.__module__, function.__qualname__
        kept = st.cache_resource(max_entries=max_entries, show_spinner=spinner)(compute)

        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> Result:
            return kept(repr(key(*args, **kwargs)), partial(function, *args, **kwargs))

        return call

    return decorate
