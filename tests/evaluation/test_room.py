import subprocess
import sys
from pathlib import Path

import corsmal.evaluation

ROOT = Path(__file__).resolve().parents[2]


def test_room_is_opened_without_pandas_torch_or_scikit_learn():
    code = "import corsmal.evaluation, sys; print(*{'torch', 'sklearn', 'pandas', 'streamlit'} & set(sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert result.stdout.split() == []


def test_every_public_name_is_there_and_none_needs_torch():
    names = ", ".join(corsmal.evaluation.__all__)
    code = f"from corsmal.evaluation import {names}; import sys; print('torch' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert result.stdout.split() == ["False"]
