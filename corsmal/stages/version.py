"""The version of the method, part of the key of everything that is kept of it."""

METHOD_VERSION = 8
"""Raised when the same inputs give another hull, estimate or anything else that is computed from them than before."""

READING_VERSION = 2
"""Raised when files that are not as the published set's are read in another way than before. It belongs to the keys of
recordings that were filmed; the demo's own files are always written in the same way."""
