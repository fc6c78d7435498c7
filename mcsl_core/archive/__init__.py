"""An archive: many recordings, worked through by an engine that exists, and what of them needs a person."""
