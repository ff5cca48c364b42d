"""Studies of the methods and of the physics, each a command and a page of the docs."""
