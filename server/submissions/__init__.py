"""What was sent, and what was dealt to whom; who waits for which job, and the news of it."""
