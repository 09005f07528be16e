"""The page of a class on the courses of a platform that are tied to it."""
