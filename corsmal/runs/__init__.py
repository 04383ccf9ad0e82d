"""Runs: estimates of many recordings under a name; attribution, sweeps, and what is learned from a dataset."""

from corsmal.runs.keeping import delete_run, deleted_runs, label_run, restore_run
from corsmal.runs.making import make_run
from corsmal.runs.reproduction import Reproduction, reproduce
from corsmal.runs.run import Run, list_runs, load_run

__all__ = [
    "Reproduction",
    "Run",
    "delete_run",
    "deleted_runs",
    "label_run",
    "list_runs",
    "load_run",
    "make_run",
    "reproduce",
    "restore_run",
]
