def repondre(contexte):
    raise ValueError("x" * (contexte["frame_bytes"] * 4))
