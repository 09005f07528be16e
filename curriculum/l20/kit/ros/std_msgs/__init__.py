"""Messages courants."""
