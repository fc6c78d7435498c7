"""The cut in the languages of other editors: written for them, and their changes read back as overrides."""
