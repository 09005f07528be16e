from kalman import gain, fusionner, enchainer
