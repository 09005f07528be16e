"""Failures that answer alike, and the words that a teacher finds for them."""
