"""The recording: which files are cameras, their pictures and audio on the programme clock, samples of all cameras."""
