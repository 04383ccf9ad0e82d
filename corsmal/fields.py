"""Metadata for the fields of dataclasses."""

from collections.abc import Mapping

UNLESS_DEFAULT: Mapping[str, bool] = {"unless default": True}
"""Of a field whose default is left out of digests: such a field can be added to a record, with a default that means
what the record meant before, and what was kept under its digest is still found."""
