"""Where robots move: grid maps and distances in them, exact ray casting, seeded places, simulated runs."""
