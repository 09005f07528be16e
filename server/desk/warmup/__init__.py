"""The pages of the questions with which a class begins a lesson."""
