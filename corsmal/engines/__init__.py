"""The same task on many recordings: in turn, in processes of this machine, or on a Dask cluster."""

from corsmal.engines.dask_cluster import DaskCluster
from corsmal.engines.engine import Engine, in_turn, run_batch
from corsmal.engines.processes import Processes
from corsmal.engines.tasks import DetectTask, EstimateTask

__all__ = ["DaskCluster", "DetectTask", "Engine", "EstimateTask", "Processes", "in_turn", "run_batch"]
