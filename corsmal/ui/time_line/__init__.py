"""The page's time line: the views' pictures of one frame, and a playhead that everything on the page follows."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
