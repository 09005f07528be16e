"""Assignments of a class: exercises, dates and rules, exemptions, sittings of tests. See README.md in this folder."""
