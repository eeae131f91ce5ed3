"""A robot that pushes a box by the filter's estimates."""
