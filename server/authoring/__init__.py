"""What writes a course: skeletons, the preview, the shapes of its files, what classes' attempts teach about it."""
