"""The particle filter and its parts (Section 4), and its baseline."""
