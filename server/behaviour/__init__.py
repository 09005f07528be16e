"""Failed attempts grouped by what their programs answer, and the names that teachers give to these groups."""
