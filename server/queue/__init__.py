"""Jobs to be done later, of any kind: rows with a lease, the worker that does them, and how it learns of them."""
