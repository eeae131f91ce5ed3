"""What a user runs; below it, what that is made of."""
