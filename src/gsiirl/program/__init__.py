"""How the program speaks to whoever runs it: commands to paste, and progress."""
