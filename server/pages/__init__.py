"""The pages of exercises, attempts, accounts and classes."""
