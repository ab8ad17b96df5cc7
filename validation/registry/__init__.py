"""Which models there are, what each can do, and how one is built for a scene."""
