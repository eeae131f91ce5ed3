"""Numbers as text: cells, lines and whole tables."""
