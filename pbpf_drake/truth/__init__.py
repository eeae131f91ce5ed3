"""Simulated recordings, by a physics that isn't the filter's."""
