"""Marks of a class: those in force, those that a teacher sets, what they come to. See README.md in this folder."""
