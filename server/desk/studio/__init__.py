"""The pages on which a teacher writes exercises."""
