"""The sound of a synthetic recording: eight microphones in a room."""
