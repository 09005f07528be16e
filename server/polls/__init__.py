"""Questions asked inside the lessons: what each one said first, and how a class spread."""
