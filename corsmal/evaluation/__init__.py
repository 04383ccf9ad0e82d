"""How good the estimates are: metrics, the challenge's scores, the paper's tables, and what is behind each number.

Everything starts from an estimates table and an annotation: ``error_table`` holds them against each other, recording by
recording; ``container_table`` and the others count from it. pandas is imported only when something is asked for.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from corsmal.evaluation.attribution import KNOWN_STAGES, blame_table, with_true
    from corsmal.evaluation.challenge import SPLITS, challenge_scores, overall_score
    from corsmal.evaluation.checking import Checked, truth_table
    from corsmal.evaluation.comparison import changed_sides, compare_runs
    from corsmal.evaluation.estimates import (
        ESTIMATE_COLUMNS,
        check_estimates,
        estimates_table,
        read_estimates,
        write_estimates,
    )
    from corsmal.evaluation.exporting import TABLE_FORMATS, export_table
    from corsmal.evaluation.filling_tables import filling_confusion_tables, filling_container_table, pooled_table
    from corsmal.evaluation.metrics import confusion, joint_classes, mape, mpf1, weighted_f1
    from corsmal.evaluation.published import (
        LEADERBOARD_SPLITS,
        beside_paper,
        leaderboard,
        leaderboard_with,
        paper_table_2,
        paper_table_3,
    )
    from corsmal.evaluation.recordings import error_table
    from corsmal.evaluation.submission import (
        SUBMISSION_COLUMNS,
        check_submission,
        read_submission,
        submission_table,
        write_submission,
    )
    from corsmal.evaluation.sweep import sweep_table
    from corsmal.evaluation.tables import (
        METRICS,
        confusion_tables,
        container_table,
        metric_of,
        recordings_behind,
        recordings_confused,
    )

__all__ = [
    "ESTIMATE_COLUMNS",
    "KNOWN_STAGES",
    "LEADERBOARD_SPLITS",
    "METRICS",
    "SPLITS",
    "SUBMISSION_COLUMNS",
    "TABLE_FORMATS",
    "Checked",
    "beside_paper",
    "blame_table",
    "challenge_scores",
    "changed_sides",
    "check_estimates",
    "check_submission",
    "compare_runs",
    "confusion",
    "confusion_tables",
    "container_table",
    "error_table",
    "estimates_table",
    "export_table",
    "filling_confusion_tables",
    "filling_container_table",
    "joint_classes",
    "leaderboard",
    "leaderboard_with",
    "mape",
    "metric_of",
    "mpf1",
    "overall_score",
    "paper_table_2",
    "paper_table_3",
    "pooled_table",
    "read_estimates",
    "read_submission",
    "recordings_behind",
    "recordings_confused",
    "submission_table",
    "sweep_table",
    "truth_table",
    "weighted_f1",
    "with_true",
    "write_estimates",
    "write_submission",
]

_FILES = {
    "attribution": (
        "KNOWN_STAGES",
        "blame_table",
        "with_true",
    ),
    "challenge": (
        "SPLITS",
        "challenge_scores",
        "overall_score",
    ),
    "checking": (
        "Checked",
        "truth_table",
    ),
    "comparison": (
        "changed_sides",
        "compare_runs",
    ),
    "estimates": (
        "ESTIMATE_COLUMNS",
        "check_estimates",
        "estimates_table",
        "read_estimates",
        "write_estimates",
    ),
    "exporting": (
        "TABLE_FORMATS",
        "export_table",
    ),
    "filling_tables": (
        "filling_confusion_tables",
        "filling_container_table",
        "pooled_table",
    ),
    "metrics": (
        "confusion",
        "joint_classes",
        "mape",
        "mpf1",
        "weighted_f1",
    ),
    "published": (
        "LEADERBOARD_SPLITS",
        "beside_paper",
        "leaderboard",
        "leaderboard_with",
        "paper_table_2",
        "paper_table_3",
    ),
    "recordings": ("error_table",),
    "submission": (
        "SUBMISSION_COLUMNS",
        "check_submission",
        "read_submission",
        "submission_table",
        "write_submission",
    ),
    "sweep": ("sweep_table",),
    "tables": (
        "METRICS",
        "confusion_tables",
        "container_table",
        "metric_of",
        "recordings_behind",
        "recordings_confused",
    ),
}


def __getattr__(name: str) -> Any:
    for file, names in _FILES.items():
        if name in names:
            return getattr(importlib.import_module(f"corsmal.evaluation.{file}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
