"""The worker: it takes submissions from the queue, has them graded in the sandbox, and records the verdicts."""
