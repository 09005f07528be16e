"""The course as it is served: modules, exercises and their versions, pages, glossary, and what is malformed in them."""

from server.course.models import Course, Exercise, FunctionSpec, Module, Problem
from server.course.service import load

__all__ = ["Course", "Exercise", "FunctionSpec", "Module", "Problem", "load"]
