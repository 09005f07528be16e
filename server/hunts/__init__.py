"""Bug hunts: wrong programs of the catalogue, whose mistake one looks for; both programs run behind the walls."""
