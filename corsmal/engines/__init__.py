"""The same task on many recordings: in turn, in processes of this machine, or on a Dask cluster.

Nothing is imported here: a worker process begins with this package, and loads only what its task needs.
"""
