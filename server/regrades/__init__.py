"""Regrades: attempts are graded again, previewed before they count, then applied or undone at once."""
