"""The engine between machines: NATS JetStream carries tickets to the workers, and news to the web processes."""
