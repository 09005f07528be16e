"""Questions with which a class begins a lesson: what most of its students are to see again."""
