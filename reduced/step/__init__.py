"""One collocated step of friction: nodes, Newton iteration, first guess."""
