"""Whether an account may see or do something, asked everywhere in one way. See README.md in this folder."""
