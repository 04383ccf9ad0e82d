"""The editor of masks by hand: a component that draws, and what the server does with what was drawn."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
