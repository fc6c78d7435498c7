"""Pictures as arrays and the geometry of planes: what several stages need and none owns."""
