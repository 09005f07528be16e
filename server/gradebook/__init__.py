"""Every grading of every submission, which one counts, where each account stands, and what attempts open."""
