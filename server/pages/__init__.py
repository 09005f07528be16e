"""The pages that students and teachers read."""
