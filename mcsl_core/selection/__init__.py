"""Which camera the programme shows when, and the frame at which it switches."""
