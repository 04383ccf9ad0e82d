"""Masks by hand: drawing, proposing and following them, their history, and their way into COCO files and back.

A mask by hand belongs to one frame of one view's video. It is kept beside what a detector found there, never over it,
and takes its place only where a recording's ``masks`` are ``by-hand``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
