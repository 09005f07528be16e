"""Shared by all pages: rendering, assets, errors, values and verdicts."""
