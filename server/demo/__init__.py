"""A fictitious class, with its history and an ongoing lesson, for demonstrations."""
