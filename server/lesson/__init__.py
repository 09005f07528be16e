"""The lesson of a class while it goes on: exercises of the day, next step, students seen, and what may be projected."""
