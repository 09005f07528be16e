"""What a plain mistake gives too: a table where three numbers are asked."""


def repondre(*arguments):
    return [[0.1234] * 400] * 400
