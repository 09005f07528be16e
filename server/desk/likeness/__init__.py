"""Codes that look alike."""
