"""Dictionaries in dictionaries, thousands of them."""


def repondre(*arguments):
    return {str(a): {str(b): {str(c): None for c in range(19)} for b in range(19)} for a in range(19)}
