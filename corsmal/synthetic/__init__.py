"""The world that the demo is made of: synthetic scenes, rendered and sounded, and written as a dataset."""
