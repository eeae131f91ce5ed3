"""A recorded manipulation: read from messages, cleaned, placed in time."""
