"""The Evaluation page, section by section."""
