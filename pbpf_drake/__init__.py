"""Physics-based particle filter for Drake."""
