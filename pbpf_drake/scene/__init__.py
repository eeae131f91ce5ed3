"""Drake models of what a scene file says there is."""
