"""Training data and training of the networks bundled for the demo."""
