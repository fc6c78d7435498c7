"""What `import mcsl_core as mcsl` offers: programmes with their pictures and places, and still pictures aligned.

Everything here is thin: it knows defaults and RGB arrays, the packages below do the work.
"""
