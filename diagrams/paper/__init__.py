"""The paper's protocol, its tables and figures, and our numbers."""
