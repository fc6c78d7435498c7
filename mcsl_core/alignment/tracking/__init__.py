"""The lamp while it moves: where every camera then sees what the programme shows."""
