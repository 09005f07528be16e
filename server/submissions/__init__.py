"""What was submitted: attempts, their draws and figures, and the news of their grading."""
