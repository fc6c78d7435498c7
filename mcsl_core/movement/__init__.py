"""When the lamp moves. All cameras sit on one lamp: they start and stop together."""
