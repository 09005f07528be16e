"""Figures of the lessons and of the verdicts, drawn when they are looked at, once for all who look, and kept."""
