"""The table that the benchmarks print and write."""

import os
import subprocess
import sys
from pathlib import Path

from tests.benchmarks.conftest import Goal, Measured, Row, rows_of

ROOT = Path(__file__).resolve().parents[1]


def test_a_goal_is_a_ratio_to_the_bare_cost_or_a_time():
    bare = Measured("bare look", "g", None, 0.010)

    def verdict(median_s: float, goal: Goal) -> str:
        return Row(Measured("work", "g", None, median_s, goal), bare).verdict

    assert verdict(0.050, Goal(ratio=5)) == "met"
    assert verdict(0.051, Goal(ratio=5)) == "not met"
    assert verdict(0.003, Goal(seconds=0.003)) == "met"
    assert verdict(0.004, Goal(seconds=0.003)) == "not met"
    assert verdict(9.0, Goal()) == ""


def test_work_stands_beside_the_bare_cost_of_its_case_else_of_its_group_goals_first():
    bare = [Measured("bare look", "a", None, 1.0), Measured("bare pass", "b", "x", 2.0)]
    works = [
        Measured("plain way", "a", None, 9.0),
        Measured("free", "a", None, 8.0),
        Measured("bound", "b", "x", 4.0, Goal(ratio=3)),
        Measured("of another case", "b", "y", 4.0),
    ]
    rows = rows_of([*works, *bare])
    assert [row.cells for row in rows] == [
        ("bound, x", "pass", "4000.00", "2000.00", "2.00", "3 x", "met"),
        ("free", "look", "8000.00", "1000.00", "8.00", "", ""),
    ]


def test_the_command_writes_the_table(tmp_path):
    path = tmp_path / "table.md"
    command = [sys.executable, "-m", "pytest", "tests/benchmarks/test_shape_speed.py", "--benchmark-only"]
    command += ["-k", "measure or bare_integral", "-p", "no:cacheprovider", "--table", str(path)]
    alone = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    done = subprocess.run(command, cwd=ROOT, env=alone, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "measure a hull" in done.stdout
    first, _, heads, _, row = path.read_text(encoding="utf-8").splitlines()
    assert first.startswith("Medians on ")
    assert heads.startswith("| work | bare cost |")
    assert row.startswith("| measure a hull | integral of the radii |")
