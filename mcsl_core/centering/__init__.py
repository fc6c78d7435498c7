"""Shifting the programme so that what matters is in the middle: the field, or what viewers looked at."""
