"""Classes: who learns and teaches together, how one joins, and their lists. See README.md in this folder."""
