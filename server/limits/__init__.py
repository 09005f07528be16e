"""Rate limits: token buckets stored in the database."""
