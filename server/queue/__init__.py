"""Jobs of any kind: rows with a lease, their tasks, and how a worker learns that there is work."""
