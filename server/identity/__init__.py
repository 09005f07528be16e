"""Accounts, guests, browser sessions, API tokens, invitations and passwords."""
