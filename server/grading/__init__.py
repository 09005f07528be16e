"""Grading, one kind of job: sandbox and graders joined, and the workers that the service keeps alive."""
