"""The hooks through which stages come in, the built-ins by the same door: all that a plugin's author imports."""
