"""How often something may be done: buckets of tokens, kept in the database."""
