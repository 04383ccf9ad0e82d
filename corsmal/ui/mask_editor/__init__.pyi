from .controls import edit_control as edit_control
from .controls import editor_control as editor_control
from .controls import masks_control as masks_control
from .panel import mask_editor as mask_editor
