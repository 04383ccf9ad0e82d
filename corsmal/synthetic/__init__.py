"""Synthetic recordings of people, containers and sounds, written as datasets with their truth, and training on them.

No other room imports anything of this one but the names below.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
