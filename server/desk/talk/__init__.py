"""One student's work, and what is said of it."""
