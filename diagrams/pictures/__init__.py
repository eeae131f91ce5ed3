"""What pictures of scenes are rendered with."""
