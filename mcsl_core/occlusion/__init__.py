"""How much of the surgical field each camera sees, and at which samples."""
