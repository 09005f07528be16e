def repondre(contexte):
    return {str(k): "x" * 100 for k in range(contexte["frame_bytes"] // 100)}
