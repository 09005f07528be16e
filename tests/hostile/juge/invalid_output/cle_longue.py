"""A key that would fill the page, short enough for all answers together."""


def repondre(*arguments):
    return {"k" * 50_000: 1}
