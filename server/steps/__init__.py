"""Step by step: a student's program replayed line by line, with what each line changed."""
