"""Figures, and replays of what programs did, drawn when they are looked at, once for all who look, and kept."""
