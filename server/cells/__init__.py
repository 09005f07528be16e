"""The cells of code in the lessons, run in the sandbox for whoever reads, a few at once."""
