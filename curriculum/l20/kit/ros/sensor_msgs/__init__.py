"""Messages de capteurs."""
