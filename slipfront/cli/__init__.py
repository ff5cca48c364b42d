"""The command line: commands, their options, terminal output and exit codes."""
