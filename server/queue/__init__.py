"""The queue of submissions: rows with a lease, and how a worker learns that there is work."""
