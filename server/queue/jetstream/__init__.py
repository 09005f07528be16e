"""The engine between machines: NATS JetStream brings messages to workers, and job changes to web processes."""
