"""From a recording to an EDL: the stages in their order, and their results kept beside it."""
