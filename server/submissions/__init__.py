"""Submissions and variants (random data of an account); watchers of jobs."""
