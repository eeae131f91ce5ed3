"""What a scene file says: dataclasses, defaults, and checks."""
