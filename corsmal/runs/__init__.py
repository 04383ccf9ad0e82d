"""A run: what was asked, with what, and its rows; attribution, sweeps and what is learned from a dataset."""
