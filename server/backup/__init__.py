"""Backups of the whole database, made while it serves, and checked by restoring them."""
