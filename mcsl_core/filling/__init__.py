"""Filling the programme pixels that the chosen camera, warped, does not cover. Nothing is ever invented.

A filler gets one `FillContext` a programme frame: the chosen camera's warped picture and the means to get every other
camera's, laid in the same way, now and at other frames. Everything is in programme pixels.
"""
