"""How steady a programme is, by the paper's measures, and what viewers say of it."""
