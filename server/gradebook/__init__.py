"""What was found each time that a submission was graded, where each account stands, and what that opens."""
