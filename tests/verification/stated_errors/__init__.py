"""Coverage of the errors that this program states: how often they contain the truth, by kind, and the record of many
computations."""
