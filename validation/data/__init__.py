"""What others measured: their records as named columns, and the slip events in them."""
