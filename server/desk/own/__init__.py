"""A class as one of its students has it."""
