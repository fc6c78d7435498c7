"""The alignment of the views in every pose, from distinctive points to one perspective for the whole programme."""
