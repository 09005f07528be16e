"""Grading as one kind of job: what it reads, how sandbox and graders are joined, what it records."""
