"""How a class answered the questions of the lessons."""
