"""Regrades: what was sent is graded anew, shown before it counts, then applied or undone at once."""
