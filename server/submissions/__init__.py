"""What was sent: submissions, what was dealt to whom, and the news of their grading."""
