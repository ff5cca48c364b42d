"""The command line: commands, options, what the terminal shows, how it ends."""
