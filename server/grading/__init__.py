"""The grading worker: it grades submissions in the sandbox, and records the verdicts."""
