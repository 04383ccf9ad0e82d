"""Views that were pinned: kept on the server in named collections, seen in a tray on every page."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
