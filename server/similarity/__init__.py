"""Which codes of an assignment look alike, found on this machine and told as a question."""
