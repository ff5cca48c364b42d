"""Where the methods fail, how, and what the program does about it."""
