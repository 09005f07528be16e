"""Graders: what is asked of a submission, and what its answers mean. Runs on the trusted side only."""

from graders.discovery import Discovery, Problem, discover

__all__ = ["Discovery", "Problem", "discover"]
