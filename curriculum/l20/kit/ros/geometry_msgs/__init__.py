"""Messages de géométrie."""
