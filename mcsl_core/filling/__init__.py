"""Filling the programme pixels that lie outside the chosen camera's warped picture. Nothing is ever invented.

A filler gets one `FillContext` a programme frame: the chosen camera's warped picture and the means to read every other
camera's, warped in the same way, now and at other frames. Everything is in programme pixels.
"""
