"""What one confused comes back: the answers to questions about it, and when it is asked again."""
