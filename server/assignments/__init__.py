"""Assignments: what a class is to do, by when, by which rules, for whom they differ. See README.md in this folder."""
