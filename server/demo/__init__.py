"""A class of nobody, with its history and a lesson that goes on, for who visits."""
