from .pinning import pin_button as pin_button
from .pinning import pins as pins
from .tray import tray as tray
