"""Pictures, videos and messages of what the filter sees."""
