"""What a lidar says about a pose: the beam mixture and its learning, the likelihood field, and fewer beams."""
