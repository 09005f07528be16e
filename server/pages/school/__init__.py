"""Pages of the systems of schools: their administration, and the ways by which one comes from them."""
