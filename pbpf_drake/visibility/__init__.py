"""How much of a particle the camera sees (Section 4.3)."""
