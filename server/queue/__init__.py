"""The queue of jobs: rows with a lease, the worker that takes them, and how it learns that there is work."""
