"""Shared code of the graders of robotics modules: comparison and shrinking of poses, drawing of frames."""
