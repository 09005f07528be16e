"""Assignments: which exercises a class is to do, until when, by which rules, and for whom they differ."""
