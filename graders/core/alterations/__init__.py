"""Altered solutions: right programs changed at one place, on which the checks of an exercise are themselves tested."""
