"""Authorisation: whether an account may see or do something, decided in one place. See README.md in this folder."""
