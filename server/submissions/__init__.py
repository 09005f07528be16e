"""What was submitted and what was dealt to whom: sending, finding again, and the news of it."""
