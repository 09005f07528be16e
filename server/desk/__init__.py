"""The pages of a class: its own for a student, its desk for who teaches."""
