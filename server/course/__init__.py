"""The course as it is served: modules, exercises with their versions, lessons, glossary, and problems."""

from server.course.models import Course, Exercise, FunctionSpec, Module, Problem
from server.course.service import load_course

__all__ = ["Course", "Exercise", "FunctionSpec", "Module", "Problem", "load_course"]
