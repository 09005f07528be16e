"""The HTTP interface for programs: routes, schemas, and their documentation."""
