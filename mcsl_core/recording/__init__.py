"""The recording: which files are cameras, their pictures and sound on the programme clock, and the samples of it."""
