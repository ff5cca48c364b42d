"""Studies of the accuracy of the finite elements and the marcher, and of its cost."""
