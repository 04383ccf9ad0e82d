"""How good the estimates are: metrics, the challenge's scores, the paper's tables, and what is behind each number.

Everything starts from an estimates table and an annotation: ``error_table`` holds them against each other, recording by
recording; ``container_table`` and the others count from it. pandas is imported when a name is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
