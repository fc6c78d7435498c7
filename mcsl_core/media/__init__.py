"""Media files in and out: only the modules of this package import av (PyAV, FFmpeg's libraries).

Pictures are BGR (H, W, 3) uint8 or `Planes` (4:2:0, BT.709 limited). Sound is float32 (n, channels) in -1..1.
Times of a file are Fractions of a second as its timestamps give them; presentation timestamps are the authority.
"""
