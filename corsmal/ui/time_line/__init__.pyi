from .component import ALL_KEYS as ALL_KEYS
from .component import TIME_LINE as TIME_LINE
from .component import VIEWS as VIEWS
from .component import time_line as time_line
