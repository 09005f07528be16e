"""The gradebook of a class, and its log."""
