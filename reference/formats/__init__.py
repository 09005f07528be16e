"""What other programs read and write, as text and bytes in memory: maps, trajectories, logs, recordings."""
