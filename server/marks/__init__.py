"""Marks of a class: those in force, what a teacher sets in their place, what they come to, and files of them. See README.md in this folder."""
