"""Failed attempts grouped by the answers of their programs, and the names that teachers give to these groups."""
