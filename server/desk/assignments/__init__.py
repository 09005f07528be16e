"""Assignments and exemptions, as staff give them and as anyone reads why a date is what it is."""
