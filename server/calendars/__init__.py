"""Calendars of people's dates, read by other programs at a secret address."""
