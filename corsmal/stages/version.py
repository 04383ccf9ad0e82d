"""The version of the method, part of the key of everything that is kept of it."""

METHOD_VERSION = 5
"""Raised when the same inputs give another hull, estimate or anything else that is computed from them than before."""
