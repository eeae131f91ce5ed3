"""Many computations: where they run, what they depend on, what is kept."""
