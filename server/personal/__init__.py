"""What is kept of a person: taken away as an archive, or erased."""
