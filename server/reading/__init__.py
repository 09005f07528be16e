"""The texts of the course as they are read, the search through them, and what one takes away."""
