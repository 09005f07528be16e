"""Graders: what is asked of a submission, and what its answers mean. Runs on the trusted side only."""
