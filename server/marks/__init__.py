"""Marks of a class, and the overrides that teachers set. See README.md in this folder."""
