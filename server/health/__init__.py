"""Liveness, readiness, metrics for Prometheus, and the state of the service."""
