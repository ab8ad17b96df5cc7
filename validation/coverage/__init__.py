"""How often the errors that this program states hold the truth: kinds of them, and the record of many computations."""
