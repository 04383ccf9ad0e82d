"""The built-in demo: ready-made synthetic recordings with their truth and two runs, and networks for them."""
