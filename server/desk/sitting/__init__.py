"""Tests: students sit them, teachers release what was found."""
