"""What was found each time that a submission was graded, where each account stands, and the solutions that are open."""
