"""A whole log through a filter, from its file to what is written."""
