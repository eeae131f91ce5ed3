"""How long updates take, how exact they are, and other engines."""
