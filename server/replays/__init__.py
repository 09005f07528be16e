"""Replays: animations whose data is computed here, with `reference/`, and drawn by the reader's browser."""
