def repondre(contexte):
    return "é" * contexte["frame_bytes"]
