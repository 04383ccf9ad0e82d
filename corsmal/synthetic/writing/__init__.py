"""Writing synthetic recordings as a dataset on disk."""
