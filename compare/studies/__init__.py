"""Studies of the methods and of the physics; each is a command and a page of the documentation."""
