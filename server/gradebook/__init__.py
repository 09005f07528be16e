"""Gradings of submissions, standings of accounts, and access to solutions."""
