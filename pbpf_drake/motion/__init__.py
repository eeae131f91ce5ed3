"""Where particles go: physics and constant velocity (Sections 4.1 and 5)."""
