"""Pages for marking copies by hand, and a student's copy on one page."""
