"""The texts of the course as they are read: their drawings, and the search through them."""
