"""Where am I? Beliefs on a grid and clouds of particles: resampling, adaptation, Monte Carlo localisation."""
