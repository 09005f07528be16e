"""Classes: their members, join codes and lists of students. See README.md in this folder."""
