"""Regrades: begun, looked at, applied, undone."""
