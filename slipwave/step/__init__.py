"""One collocation step of friction: nodes, Newton iteration, first guess."""
