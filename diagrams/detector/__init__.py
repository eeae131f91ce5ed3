"""The simulated detector beside what the real one has done."""
