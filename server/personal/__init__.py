"""Personal data of an account: export as an archive, and erasure."""
