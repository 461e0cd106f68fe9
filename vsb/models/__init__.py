"""Models: what a study lets float, where it rests, its take-off, drag and ports, ready to be solved or simulated."""
