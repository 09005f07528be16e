"""One key, as long as a frame may be."""


def repondre(*arguments):
    return {"k" * (LIMITES["frame_bytes"] - 100): 1}
