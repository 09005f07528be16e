"""LTI 1.3: launches, registration of platforms, and the services of a course."""
