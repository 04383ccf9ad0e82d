"""The built-in demo: synthetic recordings in the dataset's own layout, with their truth, and networks for them."""
