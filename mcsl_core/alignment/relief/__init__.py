"""The scene as a relief over one plane, seen by all cameras: plane + parallax."""
