"""The pages of exercises, attempts and accounts."""
