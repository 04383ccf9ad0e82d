"""Runs: estimates of many recordings under a name; attribution, sweeps, and what is learned from a dataset.

A name's file is imported when the name is first used: the first page needs a run, and no reproduction.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
