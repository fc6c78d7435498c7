"""What mcsl writes for people: never over an input, never over what somebody else wrote, whole or not at all."""
