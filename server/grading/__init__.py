"""The worker of submissions: it has them graded in the sandbox, and records the verdicts."""
