"""Programme frames: one single resampling from camera pixel to programme pixel, colour, fill."""
