"""The course as it is served: modules, exercises, their statements, hints and versions."""

from server.catalogue.models import Catalogue, Exercise, FunctionSpec, Module, Problem
from server.catalogue.service import load

__all__ = ["Catalogue", "Exercise", "FunctionSpec", "Module", "Problem", "load"]
