"""Pushes that others have recorded, and what is measured on them."""
