"""The programme as media: conformed chunks, one video without Blender, the sound, presets."""
