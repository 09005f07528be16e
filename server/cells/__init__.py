"""The cells of code in the pages, run in the sandbox for whoever reads, a few at once."""
