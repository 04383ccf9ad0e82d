"""Container mass from the restored mask and the dimensions (paper 3.3).

PyTorch is imported when a name that needs it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
