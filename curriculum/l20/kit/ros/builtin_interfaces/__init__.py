"""Messages de base."""
