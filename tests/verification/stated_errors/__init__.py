"""Coverage of the errors that this program states: how often they contain the truth."""
